// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <vector>

#include "link/dronecan/messages.hpp"
#include "policies/can_ear.hpp"

namespace flotilla::policies {
namespace {

constexpr std::uint8_t kNode = 20;

template <class Message>
void put(std::vector<link::CanFrame>& out, const Message& message, std::uint8_t transfer_id = 0,
         std::uint8_t node = kNode) {
  link::Payload payload;
  const std::size_t size = write_payload(message, payload);
  std::array<link::CanFrame, 16> frames;
  const link::Route route{16, link::TransferKind::kMessage, Message::kType.id, node, 0};
  const std::size_t n = link::split_transfer(route, Message::kType, transfer_id,
                                             std::span(payload).first(size), frames);
  out.insert(out.end(), frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(n));
}

Moment said(const std::vector<link::CanFrame>& frames, const app::Parameters& p = {}) {
  CanEar ear(kNode);
  Moment n;
  n.now_us = 1'000;
  ear.read(frames, p, n);
  return n;
}

Heard heard(CanEar& ear, const std::vector<link::CanFrame>& frames) {
  Heard out;
  for (const link::CanFrame& f : frames) ear.hear(f.id, f.bytes(), app::Parameters{}, out);
  return out;
}

TEST_CASE("commands are read at the indices of the two ESCs, in one frame and in several") {
  for (const std::uint8_t stbd : std::initializer_list<std::uint8_t>{1, 3, 19}) {
    app::Parameters p;
    p.ESC_STBD = stbd;
    link::RawCommand command;
    command.count = static_cast<std::uint8_t>(stbd + 1U);
    command.cmd[0] = -8192;
    command.cmd[stbd] = 17;
    std::vector<link::CanFrame> frames;
    put(frames, command);
    const Moment n = said(frames, p);
    CHECK(n.bus.whole);
    CHECK(n.bus.ours);
    CHECK(n.bus.strangers_idle);
    CHECK(n.bus.commands == 1);
    CHECK(n.bus.size == stbd + 1);
    CHECK(n.port == -8192);
    CHECK(n.stbd == 17);
    CHECK(n.bus.loudest == 8192);
  }
}

TEST_CASE("a third ESC that is driven is detected") {
  link::RawCommand command;
  command.count = 3;
  command.cmd[2] = 1;
  std::vector<link::CanFrame> frames;
  put(frames, command);
  CHECK(!said(frames).bus.strangers_idle);
}

TEST_CASE("a transfer of several frames is complete only if no frame is missing or changed") {
  link::RawCommand command;
  command.count = 20;
  std::vector<link::CanFrame> frames;
  put(frames, command);
  REQUIRE(frames.size() > 3);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    auto some = frames;
    some.erase(some.begin() + static_cast<std::ptrdiff_t>(i));
    CHECK(!said(some).bus.whole);
    auto changed = frames;
    changed[i].data[2] ^= 1;
    CHECK(!said(changed).bus.whole);
  }
}

TEST_CASE("arming before commanding is told apart from the reverse order") {
  for (const bool first : {true, false}) {
    std::vector<link::CanFrame> frames;
    if (first) put(frames, link::ArmingStatus{255});
    put(frames, link::RawCommand{2, {}});
    if (!first) put(frames, link::ArmingStatus{255});
    const Moment n = said(frames);
    CHECK(n.arming == 255);
    CHECK(n.bus.told_before == first);
  }
}

TEST_CASE("another controller is heard by either of its messages, under any node id") {
  for (const std::uint8_t node : {kNode, std::uint8_t{77}}) {
    CanEar ear(kNode);
    std::vector<link::CanFrame> command, arming, status;
    put(command, link::RawCommand{2, {}}, 0, node);
    put(arming, link::ArmingStatus{}, 0, node);
    put(status, link::NodeStatus{}, 0, node);
    CHECK(heard(ear, command).controller);
    CHECK(heard(ear, arming).controller);
    CHECK(!heard(ear, status).controller);
  }
}

TEST_CASE("an ESC is heard by its index, and its reboot by its uptime") {
  CanEar ear(kNode);
  const auto status = [](std::uint8_t index) {
    std::vector<link::CanFrame> frames;
    link::EscStatus m;
    m.esc_index = index;
    put(frames, m, 0, 31);
    return frames;
  };
  const auto uptime = [](std::uint32_t seconds, std::uint8_t node = 31) {
    std::vector<link::CanFrame> frames;
    put(frames, link::NodeStatus{seconds}, 0, node);
    return frames;
  };
  CHECK(!heard(ear, status(2)).escs[0]);
  CHECK(heard(ear, status(1)).escs == std::array{false, true});
  CHECK(!heard(ear, uptime(100)).rebooted);
  CHECK(!heard(ear, uptime(101)).rebooted);
  CHECK(!heard(ear, uptime(3, 99)).rebooted);  // no ESC
  CHECK(heard(ear, uptime(100)).rebooted);
  CHECK(!heard(ear, uptime(101)).rebooted);
}

}  // namespace
}  // namespace flotilla::policies
