// SPDX-License-Identifier: MIT
// Rights to command a vehicle, and messages addressed to others.
#include <array>

#include "app/operator/ship.hpp"

namespace flotilla::app {
namespace {

TEST_CASE("where one ground station commands, no other does; all may read values and stop") {
  Parameters p;
  p.MAV_GCS_SYSID = 255;
  Ship s(p);
  s.bring_to(State::kFormation);
  const auto result = [&](std::uint16_t id, float first, float second = 0) {
    s.hear(s.stranger, link::CommandLong{id, {first, second, 1, 1, 0, 0, 0}, {1, 1}, 0});
    s.tick();
    const auto acks = s.all<link::CommandAck>();
    REQUIRE(acks.size() == 1);
    CHECK(acks[0].target == link::Address{99, 1});
    return acks[0].result;
  };
  CHECK(result(400, 1) == mav::kDenied);
  CHECK(result(176, 1, 4) == mav::kDenied);
  CHECK(result(209, 1) == mav::kDenied);
  CHECK(result(245, 1) == mav::kDenied);
  CHECK(result(511, 30, 1e6F) == mav::kDenied);
  CHECK(s.state() == State::kFormation);
  CHECK(s.vehicle->take_save_request() == SaveRequest::kNone);
  s.hear(s.stranger, link::SetMode{4, 1, 1});
  s.hear(s.stranger, link::ParamSet{7, {1, 1}, text<16>("FORM_OFS_N"), mav::kParamReal32});
  s.tick();
  CHECK(s.all<link::CommandAck>().empty());
  std::size_t errors = s.all<link::ParamError>().size();
  for (const auto& r : s.heard[0]) errors += std::holds_alternative<std::monostate>(r.message);
  CHECK(errors >= 1);  // boats do not read PARAM_ERROR
  CHECK(s.values("FORM_OFS_N").size() <= 1);
  CHECK(s.state() == State::kFormation);
  CHECK(s.vehicle->parameters().FORM_OFS_N == 0);
  CHECK_FALSE(s.take_change());
  CHECK(result(512, 148) == mav::kAccepted);
  CHECK(result(510, 30) == mav::kAccepted);
  CHECK(result(519, 1) == mav::kAccepted);
  CHECK(result(520, 1) == mav::kAccepted);
  CHECK(result(185, 1) == mav::kAccepted);
  CHECK(s.state() == State::kFault);
  CHECK(result(400, 0) == mav::kAccepted);
  CHECK(s.state() == State::kDisarmed);
}

/// Requests a mode by a command, sent for the first time or repeated.
void ask_mode(Ship& s, link::MavlinkEncoder& who, float mode, std::size_t link,
              std::uint8_t confirmation = 0) {
  s.hear(who, link::CommandLong{mav::kCmdDoSetMode, {1, mode, 0, 0, 0, 0, 0}, {1, 1}, confirmation},
         link);
  s.tick();
}

TEST_CASE("a request delayed by a slower link does not undo a newer HOLD") {
  Ship s;
  s.bring_to(State::kFormation);
  ask_mode(s, s.operator_, 4, 0);
  s.pass(4);
  ask_mode(s, s.operator_, 6, 1);
  CHECK(s.state() == State::kHold);
  REQUIRE(s.all<link::CommandAck>(1).size() == 1);
  CHECK(s.all<link::CommandAck>(1)[0].result == mav::kTemporarilyRejected);
  CHECK(s.says("ask again"));
  ask_mode(s, s.operator_, 6, 0);  // the link of the HOLD
  CHECK(s.state() == State::kFormation);
  ask_mode(s, s.operator_, 4, 0);
  s.pass(5);
  ask_mode(s, s.operator_, 6, 1);
  CHECK(s.state() == State::kFormation);
}

TEST_CASE("an operator who sends HOLD on two links may undo it on either") {
  Ship s;
  s.bring_to(State::kFormation);
  ask_mode(s, s.operator_, 4, 0);
  ask_mode(s, s.operator_, 4, 1);
  ask_mode(s, s.operator_, 6, 0);
  CHECK(s.state() == State::kFormation);
}

TEST_CASE("a repeated request does not undo another operator's newer HOLD, but undoes one's own") {
  Ship s;
  s.bring_to(State::kFormation);
  ask_mode(s, s.stranger, 4, 0);
  ask_mode(s, s.operator_, 6, 0, 1);
  CHECK(s.state() == State::kHold);
  ask_mode(s, s.operator_, 6, 0);
  CHECK(s.state() == State::kFormation);
  ask_mode(s, s.operator_, 4, 0);
  ask_mode(s, s.operator_, 6, 0, 1);
  CHECK(s.state() == State::kFormation);
}

TEST_CASE(
    "a second operator's HOLD on another link does not let in what the first one's kept out") {
  Ship s;
  s.bring_to(State::kFormation);
  ask_mode(s, s.operator_, 4, 0);
  ask_mode(s, s.stranger, 4, 1);
  ask_mode(s, s.operator_, 6, 1);  // sent before the HOLD
  CHECK(s.state() == State::kHold);
  s.pass(5);
  ask_mode(s, s.operator_, 6, 1);
  CHECK(s.state() == State::kFormation);
}

TEST_CASE("commands for other vehicles are neither executed nor answered") {
  Ship s;
  s.tick();
  for (const link::Address to : {link::Address{2, 1}, {1, 2}, {2, 0}, {255, 190}}) {
    s.command(mav::kCmdComponentArmDisarm, 1, 0, to);
    s.ask(link::ParamSet{7, to, text<16>("FORM_OFS_N"), mav::kParamReal32});
  }
  s.ask(link::SetMode{6, 2, 1});
  s.tick();
  CHECK(s.all<link::CommandAck>().empty());
  CHECK(s.state() == State::kDisarmed);
  CHECK(s.vehicle->parameters().FORM_OFS_N == 0);
}

TEST_CASE("a companion leaves requests to the whole system to the autopilot, except stops") {
  Parameters p;
  p.MAV_IDENTITY = 1;
  p.MAV_COMPID = 191;
  Ship s(p);
  s.tick();
  s.command(mav::kCmdComponentArmDisarm, 1, 0, {1, 0});
  s.command(mav::kCmdDoSetMode, 1, 6, {1, 0});
  s.command(mav::kCmdComponentArmDisarm, 1, 0, {1, 1});
  s.tick();
  CHECK(s.all<link::CommandAck>().empty());
  CHECK(s.state() == State::kDisarmed);
  s.command(mav::kCmdComponentArmDisarm, 1, 0, {1, 191});
  s.tick();
  CHECK(s.result() == mav::kAccepted);
  CHECK(s.state() == State::kHold);
  s.ask(link::SetMode{6, 1, 1});
  s.ask(link::CommandLong{209, {1, 0, 5, 1, 0, 0, 0}, {1, 0}, 0});
  s.tick();
  CHECK(s.state() == State::kHold);
  CHECK(s.all<link::CommandAck>().empty());
  s.command(mav::kCmdDoFlightTermination, 1, 0, {1, 0});
  s.tick();
  CHECK(s.result() == mav::kAccepted);
  CHECK(s.state() == State::kFault);
  s.command(mav::kCmdComponentArmDisarm, 0, 0, {1, 0});
  s.tick();
  CHECK(s.result() == mav::kAccepted);
  CHECK(s.state() == State::kDisarmed);
}

TEST_CASE("a companion sends under its autopilot's id once it knows it, and reports the change") {
  Parameters p;
  p.MAV_IDENTITY = 1;
  p.MAV_COMPID = 191;
  p.MAV_SYSID = 7;
  Ship s(p);
  link::MavlinkEncoder autopilot({42, 1});
  s.tick();
  for (int k = 0; k < 4; ++k) {
    s.hear(autopilot, link::Heartbeat{0, 11, 3, 1, 4});
    CHECK(s.vehicle->self().system == 7);
    CHECK_FALSE(s.take_change());
    s.pass(0.9);
  }
  CHECK(s.vehicle->self() == link::Address{42, 191});
  CHECK(s.take_change());
  CHECK_FALSE(s.take_change());
  s.command(mav::kCmdComponentArmDisarm, 1, 0, {42, 191});
  s.tick();
  CHECK(s.result() == mav::kAccepted);
  for (const auto& r : s.heard[0]) CHECK(r.from == link::Address{42, 191});
  REQUIRE(s.all<link::Heartbeat>().size() == 1);
  CHECK(s.all<link::Heartbeat>()[0].type == 18);
  CHECK(s.all<link::Heartbeat>()[0].autopilot == 8);
}

// Parameters.

TEST_CASE("no parameter changes the mode, whatever parameter file a client loads") {
  Ship s;
  s.command(mav::kCmdComponentArmDisarm, 1);
  s.tick();
  for (const float mode : {6.0F, 0.0F}) {
    s.sticks(0, 0);
    s.set("MODE", mode);
    s.tick();
    CHECK(s.state() == State::kHold);
    CHECK(s.values("MODE").empty());
    s.pass(0.5);
  }
  s.set("MODE", 6);
  s.tick();
  CHECK(s.says("MODE is an unknown parameter"));
  CHECK(s.vehicle->take_save_request() == SaveRequest::kNone);
}

TEST_CASE("setting a parameter is reported once as a change, and once as a request to save") {
  Ship s;
  s.tick();
  CHECK_FALSE(s.take_change());
  s.set("FORM_OFS_N", 5);
  CHECK_FALSE(s.take_change());
  s.tick();
  CHECK(s.vehicle->parameters().FORM_OFS_N == 5);
  CHECK(s.take_change());
  CHECK_FALSE(s.take_change());
  CHECK(s.vehicle->take_save_request() == SaveRequest::kChanged);
  CHECK(s.vehicle->take_save_request() == SaveRequest::kNone);
  s.set("FORM_OFS_N", 5);
  s.set("FORM_OFS_N", NAN);
  s.set("NO_SUCH", 5);
  s.tick();
  CHECK_FALSE(s.take_change());
  CHECK(s.vehicle->take_save_request() == SaveRequest::kNone);
}

TEST_CASE("a confirmation prevails over a changed parameter, in either order") {
  for (const bool confirm_first : {true, false}) {
    Ship s;
    s.tick();
    if (confirm_first) s.command(mav::kCmdPreflightStorage, 1);
    s.set("FORM_OFS_E", 3);
    if (!confirm_first) s.command(mav::kCmdPreflightStorage, 1);
    s.tick();
    CHECK(s.result() == mav::kAccepted);
    CHECK(s.vehicle->take_save_request() == SaveRequest::kConfirmed);
    CHECK(s.vehicle->take_save_request() == SaveRequest::kNone);
  }
  Ship s;
  s.tick();
  s.command(mav::kCmdPreflightStorage, 0);
  s.tick();
  CHECK(s.result() == mav::kDenied);
  CHECK(s.vehicle->take_save_request() == SaveRequest::kNone);
}

// Texts and broadcasts.

TEST_CASE("a text of any length reaches every link completely, in chunks as the protocol says") {
  std::uint16_t last_id = 0;
  Ship s(Parameters{}, 3);
  for (std::size_t length = 0; length <= 200; ++length) {
    std::string sentence;
    for (std::size_t k = 0; k < length; ++k) sentence += static_cast<char>('a' + k % 23);
    s.vehicle->begin(s.now_us, kTick_us);
    const std::size_t cut = length / 3;
    s.vehicle->texts().send(
        5, {sentence.substr(0, cut), "", std::string_view(sentence).substr(cut)}, s.counters);
    for (std::size_t link = 0; link < 3; ++link) {
      const auto heard = received_from(s.decoders[link], s.links.bytes(link), s.counters);
      std::string whole;
      bool ended = false;
      std::uint16_t id = 0;
      CAPTURE(length);
      for (std::size_t k = 0; k < heard.size(); ++k) {
        const auto& t = std::get<link::Statustext>(heard[k].message);
        CHECK_FALSE(ended);
        CHECK(t.severity == 5);
        CHECK(t.chunk_seq == k);
        if (k > 0) CHECK(t.id == id);
        id = t.id;
        whole += text_of(t);
        ended = text_of(t).size() < 50;
      }
      CHECK(whole == sentence);
      CHECK((id == 0) == (length <= 50));
      CHECK((heard.size() == 1) == (length <= 50));
      CHECK((ended || length == 50));
      if (id != 0) CHECK(id != (link == 0 ? last_id : 0));
      if (id != 0) last_id = id;
    }
    s.now_us += kTick_us;
  }
  CHECK(s.counters.mavlink_not_sent == 0);
}

TEST_CASE("an endless text is cut off and does not crash") {
  Ship s;
  s.vehicle->begin(s.now_us, kTick_us);
  s.vehicle->texts().send(5, {std::string(500, 'x'), std::string(500, 'y')}, s.counters);
  std::string whole;
  for (const auto& r : received_from(s.decoders[0], s.links.bytes(0), s.counters)) {
    whole += text_of(std::get<link::Statustext>(r.message));
  }
  CHECK(whole == std::string(200, 'x'));
}

TEST_CASE("heartbeats and TIMESYNC requests are sent once a second on every link") {
  Ship s;
  std::size_t beats = 0, requests = 0;
  for (int k = 0; k < 1000; ++k) {
    s.tick();
    beats += s.all<link::Heartbeat>(1).size();
    for (const auto& t : s.all<link::Timesync>(1)) requests += t.tc1 == 0 ? 1 : 0;
  }
  CHECK(beats == 10);
  CHECK(requests == 10);
}

TEST_CASE("another sender under our ids is reported every ten seconds; our own echo never") {
  Ship s;
  link::MavlinkEncoder twin({1, 1});
  std::size_t reports = 0;
  const auto count = [&] {
    for (const auto& t : s.all<link::Statustext>(1)) {
      if (text_of(t).find("another sender") != std::string::npos) {
        ++reports;
        CHECK(t.severity == mav::kSeverityCritical);
      }
    }
  };
  for (int k = 0; k < 2500; ++k) {  // link 0's output comes back on link 1
    s.tick();
    count();
    const auto out = s.links.bytes(0);
    std::span<const std::uint8_t> bytes = out;
    while (!bytes.empty()) {
      bytes = bytes.subspan(s.links.fill(1, bytes));
      s.take_all(1);
    }
  }
  CHECK(reports == 0);
  for (int k = 0; k < 2500; ++k) {
    if (k % 100 == 0) s.hear(twin, link::Heartbeat{4, 11, 0, 1, 3});
    s.tick();
    count();
  }
  CHECK(reports == 3);
}

TEST_CASE("a message for another vehicle is forwarded unchanged to the link where it was heard") {
  Ship s(Parameters{}, 3);
  link::MavlinkEncoder sister({2, 1});
  s.hear(sister, link::Heartbeat{4, 11, 3, 1, 3}, 1);
  s.tick();
  const auto frame = testing::frame_of(s.operator_, link::CommandLong{400, {1}, {2, 1}, 0});
  CHECK(s.links.fill(0, frame) == frame.size());
  s.take_all(0);
  s.tick();
  const auto on_1 = s.links.bytes(1);
  CHECK(std::search(on_1.begin(), on_1.end(), frame.begin(), frame.end()) != on_1.end());
  for (const std::size_t other : {0U, 2U}) {
    const auto bytes = s.links.bytes(other);
    CHECK(std::search(bytes.begin(), bytes.end(), frame.begin(), frame.end()) == bytes.end());
  }
  CHECK(s.all<link::CommandAck>().empty());
  CHECK(s.state() == State::kDisarmed);
}

TEST_CASE("messages that are no requests and not the vehicle's own are left to the boat") {
  Ship s;
  s.hear(s.stranger, link::LocalPositionNed{});
  s.hear(s.stranger, link::Timesync{5, 6});
  s.hear(s.stranger, link::Heartbeat{});
  s.command(mav::kCmdRequestMessage, 148);
  s.sticks(0, 0);
  s.hear(s.stranger, link::RadioStatus{50});
  link::MavlinkEncoder ourselves({1, 1});
  s.hear(ourselves, link::LocalPositionNed{});
  REQUIRE(s.left_over.size() == 3);
  CHECK(std::holds_alternative<link::LocalPositionNed>(s.left_over[0].message));
  CHECK(s.left_over[0].from == link::Address{99, 1});
}

TEST_CASE("a limited link gets the state before all else, and its limit is kept") {
  Ship s;
  s.links.bucket(0).limit(1500);
  s.pass(1);
  std::size_t bytes = 0, states = 0;
  for (int k = 0; k < 3000; ++k) {
    s.tick();
    bytes += s.links.bytes(0).size();
    states += s.all<link::LocalPositionNed>().size();
    CHECK(s.all<link::LocalPositionNed>().size() == s.all<link::Attitude>().size());
  }
  CHECK(bytes <= 30 * 1500 + 1500);
  CHECK(states >= 290);
}

}  // namespace
}  // namespace flotilla::app
