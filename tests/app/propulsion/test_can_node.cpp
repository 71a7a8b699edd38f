// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <random>
#include <vector>

#include "app/propulsion/can_node.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kTick_us = 10'000, kLimit_us = 1'200'000;

/// An ESC on the bus: its messages as frames into a node.
struct Esc {
  std::uint8_t node;
  std::uint8_t index;
  std::uint8_t transfer_id = 0;

  template <class Message>
  void tell(CanNode& to, const Message& message, std::int64_t now_us, link::Counters& counters) {
    link::Payload payload;
    const std::size_t size = write_payload(message, payload);
    std::array<link::CanFrame, 5> frames;
    const link::Route route{16, link::TransferKind::kMessage, Message::kType.id, node, 0};
    const std::size_t n = link::split_transfer(route, Message::kType, transfer_id++,
                                               std::span(payload).first(size), frames);
    for (std::size_t i = 0; i < n; ++i)
      to.on_frame(frames[i].id, frames[i].bytes(), now_us, counters);
  }
  void status(CanNode& to, std::int64_t now_us, link::Counters& counters) {
    link::EscStatus message;
    message.esc_index = index;
    tell(to, message, now_us, counters);
  }
  void health(CanNode& to, std::uint8_t health, std::int64_t now_us, link::Counters& counters) {
    link::NodeStatus message;
    message.health = health;
    tell(to, message, now_us, counters);
  }
};

/// Payloads of the single-frame messages of one type.
std::vector<std::uint8_t> first_bytes(const CanOutput& out, std::uint16_t type) {
  std::vector<std::uint8_t> found;
  for (std::size_t i = 0; i < out.count; ++i) {
    const auto route = link::route_of(out.frames[i].id);
    if (route->kind == link::TransferKind::kMessage && route->type == type) {
      found.push_back(out.frames[i].data[0]);
    }
  }
  return found;
}

TEST_CASE("an ESC is online while its status is fresh and its node is well") {
  CanNode node({20, 1}, 0);
  link::Counters counters;
  Esc esc{30, 1};
  esc.status(node, 0, counters);
  CHECK_FALSE(node.esc_online(1, 0, kLimit_us));  // its NodeStatus is missing
  esc.health(node, 0, 0, counters);
  CHECK(node.esc_online(1, 0, kLimit_us));
  CHECK_FALSE(node.esc_online(0, 0, kLimit_us));
  CHECK(node.esc_online(1, kLimit_us - 1, kLimit_us));
  CHECK_FALSE(node.esc_online(1, kLimit_us, kLimit_us));
  esc.status(node, kLimit_us, counters);
  CHECK(node.esc_online(1, kLimit_us, kLimit_us));
  for (const std::uint8_t health : std::initializer_list<std::uint8_t>{1, 2, 3}) {
    esc.health(node, health, kLimit_us, counters);
    CHECK_FALSE(node.esc_online(1, kLimit_us, kLimit_us));
  }
  esc.health(node, 0, kLimit_us, counters);
  CHECK(node.esc_online(1, kLimit_us, kLimit_us));
  for (std::int64_t t = kLimit_us; t < 6'000'000; t += 50'000) esc.status(node, t, counters);
  CHECK_FALSE(node.esc_online(1, 6'000'000, kLimit_us));  // NodeStatus is missing for 3 s
}

TEST_CASE("every tick has a RawCommand, ArmingStatus comes at 10 Hz, NodeStatus at 1 Hz") {
  CanNode node({20, 1}, 0);
  link::Counters counters;
  link::RawCommand command;
  command.count = 2;
  std::size_t raw = 0, arming = 0, status = 0;
  for (std::int64_t now = 0; now < 10'000'000; now += kTick_us) {
    CanOutput out;
    node.send(command, false, now, counters, out);
    raw += first_bytes(out, 1030).size();
    status += first_bytes(out, 341).size();
    for (const std::uint8_t byte : first_bytes(out, 1100)) {
      CHECK(byte == 0);
      ++arming;
    }
    for (std::size_t i = 0; i < out.count; ++i)
      CHECK(link::route_of(out.frames[i].id)->source == 20);
  }
  CHECK(raw == 1000);
  CHECK(arming == 100);
  CHECK(status == 10);
}

TEST_CASE("arming and disarming are sent in the same tick, not in the next tenth of a second") {
  CanNode node({20, 1}, 0);
  link::Counters counters;
  for (int k = 0; k < 100; ++k) {
    CanOutput out;
    const bool armed = k / 7 % 2 == 1;
    node.send(link::RawCommand{}, armed, k * kTick_us, counters, out);
    const auto sent = first_bytes(out, 1100);
    if (k % 7 == 0) CHECK(sent.size() == 1);
    for (const std::uint8_t byte : sent) CHECK(byte == (armed ? 255 : 0));
  }
}

TEST_CASE("a GetNodeInfo request gets one answer, with the request's transfer id") {
  CanNode node({20, 7}, 0);
  link::Counters counters;
  const link::Route question{24, link::TransferKind::kRequest, 1, 127, 20};
  const std::array<std::uint8_t, 1> tail{0xC0 | 9};
  CanOutput before, after, later;
  node.send(link::RawCommand{}, false, 0, counters, before);
  node.on_frame(link::can_id_of(question), tail, 5000, counters);
  node.send(link::RawCommand{}, false, kTick_us, counters, after);
  node.send(link::RawCommand{}, false, 2 * kTick_us, counters, later);
  std::size_t frames = 0;
  for (std::size_t i = 0; i < after.count; ++i) {
    const auto route = link::route_of(after.frames[i].id);
    if (route->kind != link::TransferKind::kResponse) continue;
    CHECK(route->destination == 127);
    CHECK(route->source == 20);
    CHECK((after.frames[i].bytes().back() & 0x1F) == 9);
    ++frames;
  }
  CHECK(frames > 5);
  for (std::size_t i = 0; i < later.count; ++i) {
    CHECK(link::route_of(later.frames[i].id)->kind == link::TransferKind::kMessage);
  }
}

TEST_CASE("echoes of our own frames, and anonymous frames, are not taken for an ESC's") {
  CanNode node({20, 1}, 0);
  link::Counters counters;
  for (const std::uint8_t sender : std::initializer_list<std::uint8_t>{0, 20}) {
    Esc echo{sender, 1};
    echo.status(node, 0, counters);
    echo.health(node, 0, 0, counters);
  }
  CHECK_FALSE(node.esc_online(1, 0, kLimit_us));
}

TEST_CASE(
    "a stop switch counts as pressed while it reports so, and when a safety switch falls silent") {
  CanNode node({20, 1}, 0);
  link::Counters counters;
  std::uint8_t tail = 0xC0;
  const auto hear = [&](std::uint32_t type, std::uint8_t first, std::int64_t now_us) {
    const std::array<std::uint8_t, 3> data{first, 1, tail++};
    const auto size = type == link::Button::kType.id ? 3U : 2U;
    std::array<std::uint8_t, 3> frame = data;
    if (size == 2) frame[1] = data[2];
    node.on_frame(0x1000003CU | type << 8U, std::span(frame).first(size), now_us, counters);
  };
  const std::uint32_t button = link::Button::kType.id, safety = link::SafetyState::kType.id;
  CHECK_FALSE(node.stop_pressed(0));
  hear(button, 2, 0);
  CHECK_FALSE(node.stop_pressed(0));
  hear(button, 1, 0);
  CHECK(node.stop_pressed(499'999));
  CHECK_FALSE(node.stop_pressed(500'000));
  hear(safety, 0, 1'000'000);
  CHECK(node.stop_pressed(1'000'000));
  CHECK(node.stop_pressed(60'000'000));
  hear(safety, 255, 60'000'000);
  CHECK_FALSE(node.stop_pressed(62'000'000));
  CHECK(node.stop_pressed(62'000'001));
  const std::array<std::uint8_t, 2> off{255, tail};
  node.on_frame(0x1000003DU | safety << 8U, off, 62'000'000, counters);
  CHECK(node.stop_pressed(62'000'001));  // another switch that is off does not replace it
}

TEST_CASE("any frames crash nothing and put no ESC online") {
  constexpr std::uint32_t kSeed = 81;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  CanNode node({20, 1}, 0);
  link::Counters counters;
  for (int i = 0; i < 100'000; ++i) {
    std::array<std::uint8_t, 8> data;
    for (auto& byte : data) byte = static_cast<std::uint8_t>(random());
    const auto id =
        static_cast<std::uint32_t>(random() % 3 == 0 ? 0x10040A00U | (random() & 0x7FU) : random());
    node.on_frame(id, std::span(data).first(random() % 9), i * 100, counters);
    CanOutput out;
    if (i % 100 == 0) node.send(link::RawCommand{}, false, i * 100, counters, out);
  }
  CHECK_FALSE(
      (node.esc_online(0, 10'000'000, kLimit_us) && node.esc_online(1, 10'000'000, kLimit_us)));
}

}  // namespace
}  // namespace flotilla::app
