// SPDX-License-Identifier: MIT
// A boat at its quay. A navigation unit, a leader, an operator and two ESCs send to it, and each
// can be silenced; the boat's output is read back. Boat and leader do not move.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/boat/boat.hpp"
#include "link/any_message.hpp"

namespace flotilla::testing {

/// B: the type used as the boat.
template <class S, class B = app::Boat<S>>
struct Harbour {
  static constexpr std::int64_t kTick_us = 10'000;

  explicit Harbour(const app::Parameters& p = app::Parameters{}, std::size_t links = 1)
      : boat(timed(p), links), received(links) {}

  /// No sender here answers TIMESYNC, and none is late.
  static app::Parameters timed(app::Parameters p) {
    p.NAV_LAG_S = p.FORM_LAG_S = 0;
    return p;
  }

  B boat;
  link::MavlinkEncoder navigation{{1, 2}}, leader{{100, 1}}, operator_{{255, 190}};
  bool navigation_talks = true, leader_talks = true, port_talks = true, stbd_talks = true;
  float leader_north_m = 0.5F;                   ///< near enough for a boat that does not respond
  std::int64_t leader_clock_us = 5'000'000'000;  ///< leader's time − ours
  std::int64_t now_us = 1'000'000;
  std::uint8_t esc_transfer = 0, node_transfer = 0;

  /// Output of the last tick.
  link::RawCommand raw{};
  std::vector<std::vector<link::Message>> received;
  /// The last ArmingStatus sent.
  std::optional<std::uint8_t> arming;

  static link::Odometry state(std::int64_t stamp_us, float north_m, float speed) {
    link::Odometry m{};
    m.time_usec = static_cast<std::uint64_t>(stamp_us);
    m.x = north_m;
    m.q = {1, 0, 0, 0};
    m.vx = speed;
    m.frame_id = 1;
    m.child_frame_id = 12;
    return m;
  }

  void tell(link::MavlinkEncoder& who, const link::Message& message, std::size_t link = 0) {
    boat.on_mavlink(frame_of(who, message), now_us, link);
  }

  void command(std::uint16_t number, float first, float second = 0, std::size_t link = 0) {
    tell(operator_, link::CommandLong{number, {first, second, 0, 0, 0, 0, 0}, 1, 1, 0}, link);
  }
  void arm(float force = 0) { command(link::mav::kCmdComponentArmDisarm, 1, force); }
  void disarm() { command(link::mav::kCmdComponentArmDisarm, 0); }
  void mode(float number) { command(link::mav::kCmdDoSetMode, 1, number); }

  template <class Message>
  void on_bus(std::uint8_t node, std::uint8_t transfer_id, const Message& message) {
    link::Payload payload;
    const std::size_t size = write_payload(message, payload);
    std::array<link::CanFrame, 5> frames;
    const link::Route route{16, link::TransferKind::kMessage, Message::kType.id, node, 0};
    const std::size_t n = link::split_transfer(route, Message::kType, transfer_id,
                                               std::span(payload).first(size), frames);
    for (std::size_t i = 0; i < n; ++i) boat.on_can(frames[i].id, frames[i].bytes(), now_us);
  }

  /// Sends the present true state from all senders that are not silenced.
  void talk() {
    const link::GpsGlobalOrigin origin{410'000'000, 20'000'000, 0, 0};
    const bool second = now_us % 1'000'000 < kTick_us;
    if (navigation_talks) {
      link::Odometry own = state(now_us, 0, 0);
      own.q[3] = static_cast<float>(now_us / kTick_us % 3) * 1e-4F;  // as of any real instrument
      tell(navigation, own);
    }
    if (navigation_talks && second) tell(navigation, origin);
    if (leader_talks) tell(leader, state(now_us + leader_clock_us, leader_north_m, 0));
    if (leader_talks && second) tell(leader, origin);
    if (now_us % 100'000 >= kTick_us) return;
    for (const std::uint8_t index : std::initializer_list<std::uint8_t>{0, 1}) {
      if (!(index == 0 ? port_talks : stbd_talks)) continue;
      const auto node = static_cast<std::uint8_t>(30 + index);
      link::EscStatus status;
      status.esc_index = index;
      on_bus(node, esc_transfer, status);
      on_bus(node, node_transfer, link::NodeStatus{});
    }
    ++esc_transfer, ++node_transfer;
  }

  /// One tick of the boat; time does not advance.
  void tick() {
    const auto out = boat.tick(now_us);
    raw = {};
    std::size_t commands = 0;
    for (const link::CanFrame& frame : out.can) {
      const auto route = link::route_of(frame.id);
      if (route->kind != link::TransferKind::kMessage) continue;
      const auto payload = frame.bytes().first(frame.size - 1U);
      if (route->type == link::RawCommand::kType.id) {
        raw = link::read_raw_command(payload).value();
        ++commands;
      }
      if (route->type == link::ArmingStatus::kType.id) {
        arming = link::read_arming_status(payload)->status;
      }
    }
    if (commands != 1) raw.count = 0;  // both propellers, in one message, every tick
    for (std::size_t link = 0; link < received.size(); ++link) {
      link::MavlinkDecoder decoder;
      link::Counters counters;
      received[link].clear();
      for (const auto& r : received_from(decoder, out.links->bytes(link), counters)) {
        received[link].push_back(r.message);
      }
    }
  }

  void step() {
    now_us += kTick_us;
    talk();
    tick();
  }
  void sail(double seconds) {
    const std::int64_t until = now_us + static_cast<std::int64_t>(seconds * 1e6);
    while (now_us < until) step();
  }

  /// Armed, in FORMATION, pushing.
  void cast_off() {
    sail(2);
    arm();
    step();
    mode(6);
    sail(1);
  }

  bool pushes() const { return raw.count == 2 && (raw.cmd[0] != 0 || raw.cmd[1] != 0); }
  bool stopped() const { return raw.count == 2 && raw.cmd[0] == 0 && raw.cmd[1] == 0; }

  template <class Message>
  std::vector<Message> all(std::size_t link = 0) const {
    std::vector<Message> out;
    for (const link::Message& m : received[link]) {
      if (const auto* found = std::get_if<Message>(&m)) out.push_back(*found);
    }
    return out;
  }

  bool says(std::string_view what, std::size_t link = 0) const {
    for (const link::Statustext& t : all<link::Statustext>(link)) {
      if (std::string_view(t.text.data(), t.text.size()).find(what) != std::string_view::npos)
        return true;
    }
    return false;
  }
};

}  // namespace flotilla::testing
