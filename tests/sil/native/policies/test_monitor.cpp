// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <string>

#include "app/operator/telemetry/text.hpp"
#include "policies/monitor.hpp"
#include "policies/rules.hpp"
#include "policies/watched_boat.hpp"

namespace flotilla::policies {
namespace {

using core::State;
namespace mav = link::mav;
using testing::WatchedHarbour;

TEST_CASE_TEMPLATE("a boat that is armed, sails, is stopped and sails again breaks no rule", S,
                   float, double) {
  WatchedHarbour<S> h;
  h.cast_off();
  REQUIRE(h.boat.state() == State::kFormation);
  REQUIRE(h.pushes());
  h.leader_talks = false;
  h.sail(2);
  h.leader_talks = true;
  h.disarm();
  h.sail(1);
  h.cast_off();
  h.command(mav::kCmdDoFlightTermination, 1);
  h.sail(1);
  REQUIRE(h.boat.state() == State::kFault);
  h.disarm();
  h.sail(1);
  h.arm();
  h.step();
  h.command(mav::kCmdDoMotorTest, 1);
  h.sail(1);
  h.port_talks = false;
  h.sail(3);
  CHECK(h.boat.broken() == "");
}

TEST_CASE("TIMESYNC requests come as often as SR_SLOW says, however it changes") {
  WatchedHarbour<> h(app::Parameters{}, 2);  // the unit speaks on the first link
  link::ParamSet set{1, {1, 1}, {}, mav::kParamReal32};
  app::put_text(set.param_id, "SR_SLOW");
  for (const double after_s : {0.02, 0.3, 0.97, 1.0, 1.04, 4.0, 11.0}) {
    for (const float rate_Hz : {0.1F, 1.0F, 0.3F, 0.0F, 0.15F, 20.0F, 0.9F, 1e-6F}) {
      set.param_value = rate_Hz;
      h.tell(h.operator_, set);
      h.sail(after_s);
      CAPTURE(after_s);
      CAPTURE(rate_Hz);
      REQUIRE(h.boat.broken() == "");
    }
  }
}

/// The first broken rule if sent frames of a type are changed from now on.
std::string_view broken_by(WatchedHarbour<>& h, std::uint16_t type,
                           const std::function<void(link::CanFrame&)>& change) {
  h.boat.bus = [type, change](std::vector<link::CanFrame>& frames) {
    for (link::CanFrame& frame : frames) {
      if ((frame.id >> 8U & 0xFFFFU) == type) change(frame);
    }
  };
  h.sail(1.5);
  return h.boat.broken();
}

std::uint16_t type_of(auto message) { return decltype(message)::kType.id; }

TEST_CASE("disarmed, a nonzero command is reported at once") {
  WatchedHarbour<> h;
  h.sail(2);
  const std::int64_t last_us = h.now_us;
  const auto push = [](link::CanFrame& f) { f.data[0] = 0x40; };
  CHECK(broken_by(h, type_of(link::RawCommand{}), push) ==
        "DISARMED: commands are zero within a tick");
  CHECK(h.boat.violation()->now_us == last_us + WatchedHarbour<>::kTick_us);
}

TEST_CASE("the first violation is kept") {
  WatchedHarbour<> h;
  h.sail(2);
  broken_by(h, type_of(link::RawCommand{}), [](link::CanFrame& f) { f.data[0] = 0x40; });
  const Violation first = *h.boat.violation();
  h.boat.bus = [](std::vector<link::CanFrame>& frames) { frames.clear(); };
  h.sail(1);
  CHECK(h.boat.violation()->name == first.name);
  CHECK(h.boat.violation()->now_us == first.now_us);
}

TEST_CASE("frames that are changed on the bus break the rules about them") {
  const auto after = [](std::uint16_t type, auto change) {
    WatchedHarbour<> h;
    h.sail(2);
    return broken_by(h, type, change);
  };
  const auto id = [](link::CanFrame& f) { f.data[f.size - 1U] ^= 1; };
  const auto command = type_of(link::RawCommand{}), arming = type_of(link::ArmingStatus{}),
             status = type_of(link::NodeStatus{});
  CHECK(after(arming, [](auto& f) { f.data[0] = 255; }) == "ArmingStatus 255 only while armed");
  CHECK(after(arming, [](auto& f) { f.data[0] = 128; }) == "ArmingStatus is 0 or 255");
  CHECK(after(arming, [](auto& f) { f.id ^= 1U << 15U; }) ==
        "ArmingStatus is sent at least every 0.11 s");
  CHECK(after(status, [](auto& f) { f.id ^= 1U << 15U; }) ==
        "NodeStatus is sent at least every 1.1 s");
  CHECK(after(status, [](auto& f) { f.data[0] = 0; }) == "a node's uptime never runs backwards");
  CHECK(after(status, [](auto& f) { f.data[4] = 0x40; }) ==
        "NodeStatus reports OK and operational");
  CHECK(after(command, [](auto& f) { f.id ^= 1U; }) == "every frame is from CAN_NODE");
  CHECK(after(command, [](auto& f) { f.id ^= 1U << 15U; }) == "one RawCommand in every tick");
  const auto cut = [](auto& f) {
    f.data[2] = f.data[f.size - 1U];  // room for one
    f.size = 3;
  };
  CHECK(after(command, cut) == "RawCommand names both propellers' ESCs");
  CHECK(after(status, [](auto& f) { f.data[f.size - 1U] ^= 0x20; }) ==
        "every transfer is complete and its checksum correct");
  CHECK(after(arming, id) == "transfer ids increase by one");
}

TEST_CASE("a boat armed without a command breaks the rule for it") {
  WatchedHarbour<> h;
  h.sail(2);
  std::vector<std::uint8_t> unheard = testing::frame_of(
      h.operator_,
      link::CommandLong{mav::kCmdComponentArmDisarm, {1, 0, 0, 0, 0, 0, 0}, {1, 1}, 0});
  h.boat.firmware().on_mavlink(unheard, h.now_us, 0);
  h.step();
  CHECK(h.boat.state() == State::kHold);
  CHECK(h.boat.broken() == "armed only after a command to arm");
}

TEST_CASE("a leader lost in the tick of the FORMATION request: COAST at once, no rule broken") {
  WatchedHarbour<> h;
  h.sail(2);
  h.arm();
  h.step();
  h.mode(6);
  link::ParamSet set{101, {1, 1}, {}, mav::kParamReal32};
  app::put_text(set.param_id, "FORM_LEADER");
  h.tell(h.operator_, set);
  h.step();
  CHECK(h.boat.state() == State::kCoast);
  CHECK(h.boat.broken() == "");
}

TEST_CASE("a track moved by another sender is reported") {
  WatchedHarbour<> h;
  h.sail(2);
  h.leader_talks = false;
  h.sail(0.1);
  const auto state = h.state(h.now_us + h.leader_clock_us, h.leader_north_m, 0);
  h.boat.firmware().on_mavlink(testing::frame_of(h.leader, state), h.now_us, 0);
  h.step();
  CHECK(h.boat.broken() == "a foreign system id never moves the leader's track");
}

TEST_CASE("silent links break the rule of the heartbeat") {
  WatchedHarbour<> h;
  h.sail(2);
  std::array<app::MavlinkLinks::Link, 1> room;
  std::array<app::Datagram, 1> nothing;
  app::MavlinkLinks silent({1, 1}, room, nothing);
  h.boat.links = &silent;
  const std::int64_t last_us = h.now_us;
  h.sail(2);
  CHECK(h.boat.broken() == "HEARTBEAT is sent at least every 1.1 s");
  CHECK(h.boat.violation()->now_us < last_us + 1'200'000);
}

TEST_CASE("bytes that come in pieces and damaged break no rule") {
  WatchedHarbour<> h;
  h.sail(2);
  const auto frame = testing::frame_of(
      h.operator_, link::CommandLong{mav::kCmdComponentArmDisarm, {1}, {1, 1}, 0});
  h.boat.on_mavlink(std::span(frame).first(20), h.now_us, 0);
  h.step();
  h.boat.on_mavlink(std::span(frame).subspan(20), h.now_us, 0);
  h.step();
  CHECK(h.boat.broken() == "");
}

}  // namespace
}  // namespace flotilla::policies
