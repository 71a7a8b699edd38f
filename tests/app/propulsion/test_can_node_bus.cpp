// SPDX-License-Identifier: MIT
// A boat's node on a bus with nodes that claim the same role, reboot, or send nonsense.
#include <doctest/doctest.h>

#include <vector>

#include "app/propulsion/can_node.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kLimit_us = 1'200'000, kSecond_us = 1'000'000;

/// Node 20 and its bus.
struct Bus {
  CanNode node{{20, 1}, 0};
  link::Counters counters;
  std::uint8_t transfer_id = 0;

  void bytes(const link::Route& route, const link::DataType& type,
             std::span<const std::uint8_t> payload, std::int64_t now_us) {
    std::array<link::CanFrame, 8> frames;
    const std::size_t n = link::split_transfer(route, type, transfer_id++, payload, frames);
    for (std::size_t i = 0; i < n; ++i)
      node.on_frame(frames[i].id, frames[i].bytes(), now_us, counters);
  }
  template <class Message>
  void tell(std::uint8_t from, const Message& message, std::int64_t now_us) {
    link::Payload payload;
    const std::size_t size = write_payload(message, payload);
    bytes({16, Message::kType.kind, Message::kType.id, from, 0}, Message::kType,
          std::span(payload).first(size), now_us);
  }
  void esc(std::uint8_t from, std::int64_t now_us, std::uint32_t uptime_s = 100) {
    link::EscStatus status;
    status.esc_index = 1;
    tell(from, status, now_us);
    tell(from, link::NodeStatus{uptime_s}, now_us);
  }
  bool online(std::int64_t now_us) const { return node.esc_online(1, now_us, kLimit_us); }
  CanOutput tick(std::int64_t now_us) {
    CanOutput out;
    node.send({}, false, now_us, counters, out);
    return out;
  }
};

TEST_CASE("another node that commands or arms ESCs is known for two seconds, even under our id") {
  for (const std::uint8_t from : {std::uint8_t{55}, std::uint8_t{20}}) {
    Bus bus;
    CHECK_FALSE(bus.node.foreign_controller(0));
    bus.tell(from, link::RawCommand{2}, 0);
    CHECK(bus.node.foreign_controller(2 * kSecond_us - 1));
    CHECK_FALSE(bus.node.foreign_controller(2 * kSecond_us));
    bus.tell(from, link::ArmingStatus{}, 5 * kSecond_us);
    CHECK(bus.node.foreign_controller(6 * kSecond_us));
    bus.bytes({16, link::RpmCommand::kType.kind, link::RpmCommand::kType.id, from, 0},
              link::RpmCommand::kType, std::array<std::uint8_t, 5>{}, 10 * kSecond_us);
    CHECK(bus.node.foreign_controller(11 * kSecond_us));
  }
}

TEST_CASE("an ESC's status or node status that is too short is counted and ignored") {
  Bus bus;
  bus.bytes({16, link::TransferKind::kMessage, 1034, 30, 0}, link::EscStatus::kType,
            std::array<std::uint8_t, 5>{}, 0);
  CHECK(bus.counters.can_bad_value == 1);
  bus.bytes({16, link::TransferKind::kMessage, 341, 30, 0}, link::NodeStatus::kType,
            std::array<std::uint8_t, 3>{}, 0);
  CHECK(bus.counters.can_bad_value == 2);
  CHECK_FALSE(bus.online(0));
}

TEST_CASE("an ESC that two nodes claim is offline, until the second is silent for 3 s") {
  Bus bus;
  bus.esc(30, 0);
  CHECK(bus.online(500'000));
  bus.esc(31, 600'000);
  bus.esc(30, kSecond_us);
  CHECK_FALSE(bus.online(kSecond_us));
  for (int s = 2; s < 5; ++s) bus.esc(30, s * kSecond_us);
  CHECK(bus.online(4 * kSecond_us));
}

TEST_CASE("an ESC that was silent for 3 s may come back from another node") {
  Bus bus;
  bus.esc(30, 0);
  bus.esc(31, 4 * kSecond_us);
  CHECK(bus.online(4 * kSecond_us));
  CHECK(bus.node.esc_status(1, 4 * kSecond_us));
  CHECK_FALSE(bus.node.esc_status(1, 8 * kSecond_us));
}

TEST_CASE("an ESC that rebooted is offline for half a second: it has to see zeros first") {
  Bus bus;
  bus.esc(30, 0, 100);
  bus.esc(30, kSecond_us, 101);
  CHECK(bus.online(kSecond_us));
  bus.esc(30, 2 * kSecond_us, 0);
  CHECK_FALSE(bus.online(2 * kSecond_us));
  CHECK_FALSE(bus.online(2 * kSecond_us + 499'999));
  CHECK(bus.online(2 * kSecond_us + 500'000));
}

TEST_CASE("an ESC whose node is not operational or not healthy may not be driven") {
  for (const auto& [health, mode] : {std::pair{0, 2}, std::pair{1, 0}, std::pair{3, 7}}) {
    Bus bus;
    bus.esc(30, 0);
    link::NodeStatus status{101};
    status.health = static_cast<std::uint8_t>(health);
    status.mode = static_cast<std::uint8_t>(mode);
    bus.tell(30, status, kSecond_us);
    CHECK_FALSE(bus.online(kSecond_us));
  }
}

TEST_CASE("more GetNodeInfo requests than a tick can answer are counted, not answered") {
  Bus bus;
  for (std::uint8_t asker = 100; asker < 106; ++asker) {
    bus.bytes({24, link::TransferKind::kRequest, 1, asker, 20}, link::NodeInfo::kRequest, {}, 0);
    bus.bytes({24, link::TransferKind::kRequest, 1, asker, 21}, link::NodeInfo::kRequest, {}, 0);
  }
  CHECK(bus.counters.can_not_sent == 2);
  std::size_t last_frames = 0;
  const CanOutput out = bus.tick(0);
  for (std::size_t i = 0; i < out.count; ++i) {
    const auto route = link::route_of(out.frames[i].id);
    const bool last = (out.frames[i].bytes().back() & 0x40U) != 0;
    if (route->kind == link::TransferKind::kResponse && last) ++last_frames;
  }
  CHECK(last_frames == 4);
}

TEST_CASE("a transfer that finds no room in a tick is dropped whole and counted") {
  Bus bus;
  CanOutput out;
  out.count = out.frames.size();
  bus.node.send({}, false, 0, bus.counters, out);
  CHECK(out.count == out.frames.size());
  CHECK(bus.counters.can_not_sent == 3);
}

TEST_CASE("a node without an id gets one over the bus; another allocator's answer is ignored") {
  Bus bus;
  constexpr std::array<std::uint8_t, 3> kParts{6, 6, 4};
  std::vector<link::Allocation> told;
  const auto ask = [&](std::uint8_t from) {
    std::uint8_t at = 0;
    for (const std::uint8_t size : kParts) {
      link::Allocation request{0, at == 0, size, {}};
      for (std::uint8_t i = 0; i < size; ++i)
        request.unique_id[i] = static_cast<std::uint8_t>(at + i);
      at = static_cast<std::uint8_t>(at + size);
      link::Payload payload;
      const std::size_t length = write_payload(request, payload);
      bus.bytes({30, link::TransferKind::kMessage, 1, from, 0}, link::Allocation::kType,
                std::span(payload).first(length), at);
      link::TransferReceiver receiver;
      const CanOutput out = bus.tick(at);
      for (std::size_t i = 0; i < out.count; ++i) {
        const auto route = link::route_of(out.frames[i].id);
        if (route->kind != link::TransferKind::kMessage || route->type != 1) continue;
        const auto transfer =
            receiver.push(*route, link::Allocation::kType, out.frames[i].bytes(), at, bus.counters);
        if (transfer) told.push_back(link::read_allocation(transfer->payload).value());
      }
    }
  };
  ask(44);
  CHECK(told.empty());
  ask(0);
  REQUIRE(told.size() == 3);
  CHECK(told[0].node_id == 0);
  CHECK(told[0].size == 6);
  CHECK(told[2].node_id == 125);
  CHECK(told[2].size == 16);
  CHECK(bus.node.node_ids().table().size() == 1);
}

}  // namespace
}  // namespace flotilla::app
