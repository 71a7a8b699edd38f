// SPDX-License-Identifier: MIT
// A vehicle between links and supervisor, with an operator and a stranger that send to it.
#pragma once

#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "app/convert/convert.hpp"
#include "app/operator/telemetry/text.hpp"
#include "app/operator/vehicle.hpp"
#include "link/any_message.hpp"

namespace flotilla::app {

using core::State;
namespace mav = link::mav;
using testing::frame_of;
using testing::received_from;
inline constexpr std::int64_t kTick_us = 10'000, kSecond_us = 1'000'000;
/// The conditions that depend on the world, not on the operator.
inline constexpr core::Conditions kFair = core::kDrive | core::kArming | core::kClear |
                                          core::kLocated | core::kHomeNear | core::kCoastRunning;
inline constexpr core::Choices kAllHold{.leader = core::Reaction::kHold};

inline std::string text_of(const link::Statustext& t) {
  return {t.text.data(), ::strnlen(t.text.data(), t.text.size())};
}
template <std::size_t N>
link::Text<N> text(std::string_view from) {
  link::Text<N> out{};
  put_text(out, from);
  return out;
}

/// A vehicle with two links; an operator and a stranger are behind the first one.
struct Ship {
  explicit Ship(const Parameters& p = Parameters{}, std::size_t count = 2)
      : links(Identity(configuration_of(p).start).self(),
              std::span(storage->room.links).first(count), storage->outbox.mavlink,
              storage->room.signing),
        vehicle(std::make_unique<Vehicle>(p, supervisor, links, time,
                                          Storage(storage->room, storage->outbox))),
        heard(count),
        decoders(count) {
    supervisor.choose(kAllHold);
  }

  std::unique_ptr<AmpleStorage> storage = std::make_unique<AmpleStorage>();
  Supervisor supervisor;
  MavlinkLinks links;
  TimeRequests time;
  std::unique_ptr<Vehicle> vehicle;
  link::Counters counters;
  link::MavlinkEncoder operator_{{255, 190}}, stranger{{99, 1}};
  core::Conditions world = kFair;
  std::int64_t now_us = kSecond_us;
  bool own_known = true;
  bool changed = false;  ///< a parameter or the identity, since the last query
  std::vector<std::vector<link::Received>> heard;  ///< of the last tick
  std::vector<link::MavlinkDecoder> decoders;
  std::vector<link::Received> left_over;  ///< what the vehicle leaves to the boat

  void hear(link::MavlinkEncoder& who, const link::Message& message, std::size_t link = 0) {
    const testing::Bytes frame = frame_of(who, message);
    std::span<const std::uint8_t> bytes = frame;
    while (!bytes.empty()) {
      bytes = bytes.subspan(links.fill(link, bytes));
      take_all(link);
    }
  }
  void take_all(std::size_t link) {
    link::Received received;
    while (links.next(link, received, now_us, counters)) {
      if (!vehicle->take(link, received, now_us, counters)) left_over.push_back(received);
    }
  }
  void ask(const link::Message& message, std::size_t link = 0) { hear(operator_, message, link); }
  void command(std::uint16_t id, float first, float second = 0, link::Address to = {1, 1}) {
    ask(link::CommandLong{id, {first, second, 0, 0, 0, 0, 0}, to, 0});
  }
  void sticks(std::int16_t surge, std::int16_t yaw) {
    ask(link::ManualControl{surge, 0, 0, yaw, 0, 1});
  }
  void set(std::string_view name, float value) {
    ask(link::ParamSet{value, {1, 1}, text<16>(name), mav::kParamReal32});
  }
  /// Sends a plan of one waypoint.
  void store_plan() {
    link::MissionCount count{};
    count.count = 1;
    count.target = {1, 1};
    ask(count);
    link::MissionItemInt item{};
    item.target = {1, 1};
    item.command = mav::kNavWaypoint;
    item.x = 410'000'000;
    item.y = 20'000'000;
    ask(item);
    tick();
    REQUIRE(vehicle->missions().plan().size() == 1);
  }
  void test_port(float percent = 5, float s = 2, std::uint8_t confirmation = 0) {
    ask(link::CommandLong{mav::kCmdDoMotorTest, {1, 0, percent, s, 0, 0, 0}, {1, 1}, confirmation});
  }

  link::FormationReference reference{};
  std::uint32_t news = 0;

  void tick() {
    vehicle->begin(now_us, kTick_us);
    vehicle->apply_conditions(world | conditions(now_us), counters);
    while (vehicle->answer(counters)) changed = vehicle->take_change() || changed;
    changed = vehicle->take_change() || changed;
    Report r;
    r.now_us = now_us;
    r.conditions = world | conditions(now_us);
    if (own_known) {
      r.own = OwnReport{convert::boot_ms(now_us), {}, true};
      r.own->state.origin = {410'000'000, 20'000'000, 0, 0};
      r.gps = link::GpsRawInt{};
      r.home = Home{410'000'000, 20'000'000, 0};
      r.fence = FenceReport{};
      r.formation = FormationReport{};
      r.reference = reference;
      vehicle->locate(r.own->state.origin);
    }
    vehicle->report(r);
    vehicle->tell(counters);
    if (vehicle->sender().waits_for_reference(news))
      vehicle->sender().send_reference(news, reference, counters);
    for (std::size_t link = 0; link < heard.size(); ++link) {
      link::Counters ignored;
      heard[link] = received_from(decoders[link], links.bytes(link), ignored);
    }
    now_us += kTick_us;
  }
  void pass(double seconds) {
    for (int k = 0; k < static_cast<int>(seconds * 100 + 0.5); ++k) tick();
  }

  template <class M>
  std::vector<M> all(std::size_t link = 0) const {
    std::vector<M> out;
    for (const link::Received& r : heard[link]) {
      if (const auto* m = std::get_if<M>(&r.message)) out.push_back(*m);
    }
    return out;
  }
  bool says(std::string_view what, std::size_t link = 0) const {
    for (const auto& t : all<link::Statustext>(link)) {
      if (text_of(t).find(what) != std::string::npos) return true;
    }
    return false;
  }
  /// The result of the one answer.
  std::uint8_t result() const {
    const auto acks = all<link::CommandAck>();
    REQUIRE(acks.size() == 1);
    CHECK(acks[0].target == link::Address{255, 190});
    return acks[0].result;
  }
  std::vector<link::ParamValue> values(std::string_view name, std::size_t link = 0) const {
    std::vector<link::ParamValue> out;  // read by hand: the boat's decoder has no use for it
    const auto bytes = links.bytes(link);
    for (std::size_t at = 0; at < bytes.size(); at += 12U + bytes[at + 1]) {
      if (bytes[at + 7] + 256U * bytes[at + 8] != 22) continue;
      link::ParamValue value{};
      std::memcpy(&value.param_value, &bytes[at + 10], 4);
      std::memcpy(value.param_id.data(), &bytes[at + 18], 16);
      if (value.param_id == text<16>(name)) out.push_back(value);
    }
    return out;
  }
  State state() const { return supervisor.state(); }
  core::Conditions conditions(std::int64_t at_us) const {
    return supervisor.conditions(at_us) | vehicle->conditions(at_us);
  }
  bool take_change() { return vehicle->take_change() || std::exchange(changed, false); }

  /// In that state, by its operator.
  void bring_to(State desired) {
    if (desired == State::kAuto && vehicle->missions().plan().empty()) store_plan();
    tick();
    if (desired != State::kDisarmed) command(mav::kCmdComponentArmDisarm, 1);
    tick();
    sticks(0, 0);
    if (desired == State::kManual) command(mav::kCmdDoSetMode, 1, 0);
    if (core::follows(desired)) command(mav::kCmdDoSetMode, 1, 6);
    if (desired == State::kAuto) world |= core::kPlanReady;
    if (desired == State::kAuto) command(mav::kCmdDoSetMode, 1, 10);
    if (desired == State::kGuided) command(mav::kCmdDoSetMode, 1, 15);
    if (desired == State::kLoiter) command(mav::kCmdDoSetMode, 1, 5);
    if (desired == State::kReturn) command(mav::kCmdDoSetMode, 1, 11);
    if (desired == State::kTest) test_port();
    if (desired == State::kFault) command(mav::kCmdDoFlightTermination, 1);
    tick();
    if (desired == State::kCoast) {
      supervisor.choose({});
      world ^= core::kLeaderFresh;
      tick();
    }
    REQUIRE(state() == desired);
  }
};

inline constexpr std::array kEveryState{
    State::kDisarmed, State::kHold, State::kManual, State::kFormation, State::kCoast, State::kTest,
    State::kFault,    State::kAuto, State::kGuided, State::kLoiter,    State::kReturn};

}  // namespace flotilla::app
