// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <limits>
#include <vector>

#include "link/any_message.hpp"
#include "policies/mavlink_ear.hpp"

namespace flotilla::policies {
namespace {

namespace mav = link::mav;
using testing::Bytes;
using testing::frame_of;

struct Ear {
  app::Parameters p{};
  MavlinkEar ear{p};
  Moment n;
  link::MavlinkEncoder self{{1, 1}}, gcs{{255, 190}}, leader{{100, 1}};

  Ear() { n.now_us = 5'000'000, n.now_ms = 5000, n.before_ms = 4990; }

  bool hear(link::MavlinkEncoder& from, const link::Message& m) {
    return ear.hear(frame_of(from, m), p, n);
  }
  void read(const Bytes& bytes) {
    n.links = {};
    ear.read(bytes, 0, n);
    ear.note_times(1, n);
  }
  void tell(const link::Message& m) { read(frame_of(self, m)); }
};

link::CommandLong command(std::uint16_t number, float first, float second = 0,
                          link::Address target = {1, 1}) {
  return {number, {first, second, 0, 0, 0, 0, 0}, target, 0};
}

TEST_CASE("a request is recognised in every possible form") {
  Ear e;
  e.hear(e.gcs, command(mav::kCmdComponentArmDisarm, 1));
  CHECK(e.n.asked[Ask::kArm] == 1);
  link::CommandInt arm{};
  arm.command = mav::kCmdComponentArmDisarm;
  arm.param[0] = 1;
  e.hear(e.gcs, arm);
  CHECK(e.n.asked[Ask::kArm] == 2);
  CHECK(e.n.asked[Ask::kAck] == 2);
  e.hear(e.gcs, command(mav::kCmdDoSetMode, 1, 6));
  e.hear(e.gcs, command(mav::kCmdDoSetMode, 129, 6));  // OFFBOARD of a PX4's client
  e.hear(e.gcs, link::CommandLong{mav::kCmdDoSetMode, {1, 6, 0, 0, 0, 0, NAN}, {1, 1}, 0});
  e.hear(e.gcs, link::SetMode{6, 1, 1});
  CHECK(e.n.asked[Ask::kFormation] == 2);
  e.hear(e.gcs, command(mav::kCmdDoSetMode, 1, 0));
  CHECK(e.n.asked[Ask::kManual] == 1);
  e.hear(e.gcs, command(mav::kCmdDoSetMode, 1, 10));
  e.hear(e.gcs, link::CommandLong{mav::kCmdDoSetMode, {1, 4, 4, 0, 0, 0, 0}, {1, 1}, 0});
  e.hear(e.gcs, link::CommandLong{mav::kCmdDoSetMode, {1, 4, 3, 0, 0, 0, 0}, {1, 1}, 0});  // HOLD
  e.hear(e.gcs, command(mav::kCmdMissionStart, 0));
  e.hear(e.gcs, command(mav::kCmdDoSetStandardMode, 6));
  e.hear(e.gcs, command(mav::kCmdDoSetStandardMode, 5));
  CHECK(e.n.asked[Ask::kAuto] == 4);
  e.hear(e.gcs, command(mav::kCmdDoMotorTest, 1));
  e.hear(e.gcs, command(mav::kCmdDoFlightTermination, 1));
  CHECK(e.n.asked[Ask::kTest] == 1);
  CHECK(e.n.asked[Ask::kTerminate] == 1);
}

TEST_CASE("a disarm is for this boat unless it names another; an arming behind it undoes nothing") {
  Ear e;
  e.hear(e.gcs, command(mav::kCmdComponentArmDisarm, 0, 0, {2, 1}));
  CHECK(e.n.heard.disarm);
  CHECK(!e.n.heard.stop);
  e.hear(e.gcs, command(mav::kCmdComponentArmDisarm, 0, 0, {0, 0}));
  CHECK(e.n.heard.stop);
  e.hear(e.gcs, command(mav::kCmdComponentArmDisarm, 1));
  CHECK(e.n.heard.stop);
}

TEST_CASE("with MAV_GCS_SYSID, arming by another station is not counted as allowed") {
  Ear e;
  e.p.MAV_GCS_SYSID = 254;
  e.hear(e.gcs, command(mav::kCmdComponentArmDisarm, 1));
  CHECK(e.n.asked[Ask::kArm] == 1);
  CHECK(e.n.asked[Ask::kArmAllowed] == 0);
}

TEST_CASE("every sender is recorded; an incomplete frame counts as torn") {
  Ear e;
  e.n.leader = static_cast<std::uint8_t>(e.p.FORM_LEADER);
  CHECK(e.hear(e.leader, link::Attitude{}));
  CHECK(e.n.heard.leader);
  CHECK(!e.n.heard.own);
  Bytes two = frame_of(e.gcs, link::Attitude{});
  const Bytes second = frame_of(e.leader, link::Attitude{});
  two.insert(two.end(), second.begin(), second.end());
  CHECK(e.ear.hear(two, e.p, e.n));
  two.pop_back();
  CHECK(!e.ear.hear(two, e.p, e.n));
  CHECK(!e.ear.hear(std::vector<std::uint8_t>{1, 2, 3}, e.p, e.n));
}

TEST_CASE("heartbeats, status texts and TIMESYNC requests are read correctly") {
  Ear e;
  e.n.state = core::State::kCoast;
  e.tell(link::Heartbeat{6, 11, 0, 129, 5});
  CHECK(e.n.links.beats);
  CHECK(e.n.links.mode == 6);
  CHECK(e.n.links.flags == 129);
  CHECK(e.n.links.status == 5);
  link::Statustext text{3, {}};
  std::ranges::copy(std::string_view("COAST: no leader"), text.text.begin());
  e.tell(text);
  CHECK(e.n.links.states_word);
  CHECK(e.n.links.gravest == 3);
  CHECK(e.n.timesync_us == 0);
  e.tell(link::Timesync{1, 2});
  CHECK(e.n.timesync_us == 0);
  e.tell(link::Timesync{0, 2});
  CHECK(e.n.timesync_us == e.n.now_us);
}

TEST_CASE("a NaN or infinity anywhere in a message is found") {
  const float none = std::numeric_limits<float>::quiet_NaN();
  Ear e;
  const auto finite = [&](const link::Message& m) {
    e.tell(m);
    return e.n.links.finite;
  };
  CHECK(finite(link::Attitude{5000, 1, 2, 3, 4, 5, 6}));
  CHECK(!finite(link::Attitude{5000, none, 2, 3, 4, 5, 6}));
  CHECK(!finite(link::Attitude{5000, 1, 2, 3, 4, 5, 1 / 0.0F}));
  CHECK(!finite(link::LocalPositionNed{5000, 1, 2, 3, 4, 5, none}));
  CHECK(!finite(link::NamedValueFloat{5000, none, {}}));
  CHECK(!finite(link::NavControllerOutput{0, 0, 0, none}));
  link::PositionTargetLocalNed slot{};
  CHECK(finite(slot));
  slot.yaw_rate = none;
  CHECK(!finite(slot));
  link::FollowTarget follow{};
  follow.rates[2] = none;
  CHECK(!finite(follow));
  link::Odometry odometry{};
  odometry.yawspeed = none;
  CHECK(!finite(odometry));
}

TEST_CASE("a message's time is right if it is this tick's or the previous one's, and no other") {
  Ear e;
  for (const auto& [ms, good] :
       {std::pair{5000U, true}, {4990U, true}, {4980U, false}, {5001U, false}}) {
    e.tell(link::NamedValueFloat{ms, 0, {}});
    CHECK(e.n.links.punctual == good);
  }
}

TEST_CASE("a skipped sequence number, a stranger's frame and half a frame are detected") {
  Ear e;
  e.tell(link::Attitude{});
  CHECK(e.n.links.counted);
  frame_of(e.self, link::Attitude{});
  e.tell(link::Attitude{});
  CHECK(!e.n.links.counted);
  Bytes handed_on = frame_of(e.leader, link::Attitude{});
  e.read(handed_on);
  CHECK(!e.n.links.ours);
  e.hear(e.leader, link::Attitude{});
  e.read(handed_on);
  CHECK(e.n.links.ours);
  const Bytes own = frame_of(e.self, link::Attitude{});
  handed_on.insert(handed_on.begin(), own.begin(), own.end());
  e.read(handed_on);
  CHECK(!e.n.links.others_first);
  handed_on.pop_back();
  e.read(handed_on);
  CHECK(!e.n.links.whole);
}

}  // namespace
}  // namespace flotilla::policies
