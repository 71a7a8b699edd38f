// SPDX-License-Identifier: MIT
// The vehicle alone, without courses and thrusts: who it is, what it answers, what it tells.
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <functional>
#include <memory>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "app/convert/convert.hpp"
#include "app/every_id.hpp"
#include "app/operator/text.hpp"
#include "app/operator/vehicle.hpp"
#include "link/any_message.hpp"

namespace flotilla::app {
namespace {

using core::State;
namespace mav = link::mav;
using testing::frame_of;
using testing::received_from;
constexpr std::int64_t kTick_us = 10'000, kSecond_us = 1'000'000;
/// All that the world, and not the operator, makes.
constexpr core::Conditions kFair = core::kDrive | core::kArming | core::kClear | core::kLocated |
                                   core::kHomeNear | core::kCoastRunning;
constexpr core::Choices kAllHold{.leader = core::Reaction::kHold};

std::string text_of(const link::Statustext& t) {
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
  bool changed = false;  ///< since somebody looked: a parameter or the identity
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
    if (vehicle->waits_for_reference(news)) vehicle->tell_reference(news, reference, counters);
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

constexpr std::array kEveryState{
    State::kDisarmed, State::kHold, State::kManual, State::kFormation, State::kCoast, State::kTest,
    State::kFault,    State::kAuto, State::kGuided, State::kLoiter,    State::kReturn};

// Answers.

TEST_CASE("every message that is asked for comes after its one ACK, in the same tick") {
  for (const std::uint16_t id : testing::kEveryId) {
    Ship s;
    s.pass(0.05);
    s.store_plan();
    s.command(mav::kCmdRequestMessage, static_cast<float>(id));
    s.tick();
    CAPTURE(id);
    CHECK(s.result() == mav::kAccepted);
    const auto bytes = s.links.bytes(0);
    std::vector<std::uint32_t> ids;
    for (std::size_t at = 0; at < bytes.size(); at += 12U + bytes[at + 1]) {
      ids.push_back(bytes[at + 7] + 256U * bytes[at + 8]);
    }
    const auto ack = std::find(ids.begin(), ids.end(), 77U);
    const auto message = std::find(ids.begin(), ids.end(), id);
    REQUIRE(ack != ids.end());
    REQUIRE(message != ids.end());
    CHECK(ack < message);
    CHECK(s.all<link::CommandAck>(1).empty());
  }
}

TEST_CASE("what there is not is unsupported, what there is not now comes later; nothing follows") {
  Ship s;
  s.own_known = false;
  s.pass(0.05);
  const auto answer_to = [&](std::uint16_t id) {
    s.command(mav::kCmdRequestMessage, id);
    s.tick();
    return s.result();
  };
  for (const std::uint16_t id :
       {link::Attitude::kId, link::LocalPositionNed::kId, link::Odometry::kId,
        link::HomePosition::kId, link::GpsGlobalOrigin::kId, link::FormationReference::kId,
        link::GpsRawInt::kId, link::VfrHud::kId}) {
    CAPTURE(id);
    CHECK(answer_to(id) == mav::kTemporarilyRejected);
  }
  for (const std::uint16_t id :
       {std::uint16_t{25}, std::uint16_t{147 + 1000}, std::uint16_t{65535}})
    CHECK(answer_to(id) == mav::kUnsupported);
  s.command(mav::kCmdRequestMessage, link::AvailableModes::kId, 8);
  s.tick();
  CHECK(s.result() == mav::kUnsupported);
  CHECK(s.all<link::AvailableModes>().empty());
}

/// In which ticks of the next ones the reference was told, `told` s.
std::vector<int> references(Ship& s, int ticks, const std::function<bool(int)>& is_news) {
  std::vector<int> told;
  for (int k = 0; k < ticks; ++k) {
    if (is_news(k)) ++s.news;
    s.tick();
    if (!s.all<link::FormationReference>().empty()) told.push_back(k);
  }
  return told;
}

TEST_CASE("the reference is told ten times a second, news or none, and on every link") {
  Ship s;
  s.pass(1);
  CHECK(references(s, 1000, [](int) { return false; }).size() == 100);
  CHECK(references(s, 1000, [](int) { return true; }).size() <= 101);  // the first one early
  int links = 0;
  for (int k = 0; k < 10; ++k) {
    s.tick();
    for (std::size_t link = 0; link < s.heard.size(); ++link) {
      links += s.all<link::FormationReference>(link).empty() ? 0 : 1;
    }
  }
  CHECK(links == static_cast<int>(s.heard.size()));
}

TEST_CASE("news goes on at once, up to half a turn early, but is never told twice as often") {
  Ship s;
  s.pass(1);
  while (references(s, 1, [](int) { return false; }).empty()) {
  }
  // The next turn is ten ticks later; from here on news comes three ticks before each.
  const auto told = references(s, 200, [](int k) { return k % 10 == 6; });
  REQUIRE(told.size() == 20);
  for (const int k : told) CHECK(k % 10 == 6);
}

TEST_CASE("with SR_STATE 2 the reference is told four times a second, with 0 never") {
  for (const auto& [rate, times] : {std::pair{2.0F, 40U}, {0.0F, 0U}, {100.0F, 100U}}) {
    Parameters p;
    p.SR_STATE = rate;
    Ship s(p);
    s.pass(1);
    CHECK(references(s, 1000, [](int) { return false; }).size() == times);
  }
}

TEST_CASE("what was set is in force before anything that was asked behind it") {
  Ship s;
  s.tick();
  s.set("MAV_GCS_SYSID", 99);
  s.command(mav::kCmdComponentArmDisarm, 1);  // of 255
  s.set("LAW_KX", 0.5F);                      // too
  s.vehicle->begin(s.now_us, kTick_us);
  s.vehicle->apply_conditions(s.world, s.counters);
  CHECK(s.vehicle->answer(s.counters));  // there is more, but first:
  CHECK(s.vehicle->parameters().MAV_GCS_SYSID == 99);
  CHECK(s.links.bytes(0).empty());
  CHECK(s.take_change());
  CHECK_FALSE(s.vehicle->answer(s.counters));
  CHECK_FALSE(s.take_change());
  CHECK(s.state() == State::kDisarmed);
  s.vehicle->tell(s.counters);
  const auto heard = received_from(s.decoders[0], s.links.bytes(0), s.counters);
  const auto ack = std::find_if(heard.begin(), heard.end(), [](const link::Received& r) {
    return std::holds_alternative<link::CommandAck>(r.message);
  });
  REQUIRE(ack != heard.end());
  CHECK(std::get<link::CommandAck>(ack->message).result == mav::kDenied);
}

TEST_CASE("however many parameters are set in a tick, all that is asked is answered, in order") {
  Ship s;
  s.tick();
  for (int k = 0; k < 6; ++k) {
    s.set("LAW_KX", 0.25F + 0.125F * float(k % 2));
    s.command(mav::kCmdComponentArmDisarm, k % 2 == 0 ? 1 : 0);
  }
  s.tick();
  CHECK(s.changed);
  const auto acks = s.all<link::CommandAck>();
  REQUIRE(acks.size() == 6);
  for (const auto& ack : acks) CHECK(ack.result == mav::kAccepted);
  CHECK(s.state() == State::kDisarmed);
  CHECK(s.vehicle->parameters().LAW_KX == 0.375F);
}

TEST_CASE("a disarm behind any flood of requests is answered with the next tick") {
  constexpr std::uint32_t kSeed = 61;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (const State from :
       {State::kHold, State::kManual, State::kFormation, State::kCoast, State::kTest}) {
    for (int round = 0; round < 30; ++round) {
      Ship s;
      s.bring_to(from);
      for (auto n = random() % 80; n > 0; --n) {
        switch (random() % 4) {
          case 0:
            s.command(mav::kCmdRequestMessage, link::AutopilotVersion::kId);
            break;
          case 1:
            s.set("LAW_KX", 0.25F + 0.125F * float(random() % 4));
            break;
          case 2:
            s.command(mav::kCmdComponentArmDisarm, 1);
            break;
          default:
            s.ask(link::ParamRequestList{{1, 1}});
        }
      }
      s.command(mav::kCmdComponentArmDisarm, 0);
      for (int k = 0; k < 5; ++k) {  // nor is it undone by an arming that found no room before it
        s.tick();
        REQUIRE(s.state() == State::kDisarmed);
      }
    }
  }
}

TEST_CASE("modes are listed all for 0, and one by one for their index") {
  Ship s;
  s.tick();
  s.command(mav::kCmdRequestMessage, link::AvailableModes::kId, 0);
  s.tick();
  CHECK(s.links.bytes(0).size() > 3 * 20);
  for (const float index : {1.0F, 2.0F, 3.0F}) {
    s.command(mav::kCmdRequestMessage, link::AvailableModes::kId, index);
    s.tick();
    CHECK(s.result() == mav::kAccepted);
    const auto bytes = s.links.bytes(0);
    std::vector<unsigned> indices;
    for (std::size_t at = 0; at < bytes.size(); at += 12U + bytes[at + 1]) {
      if (bytes[at + 7] + 256U * bytes[at + 8] == 435) indices.push_back(bytes[at + 10 + 9]);
    }
    CHECK(indices == std::vector{static_cast<unsigned>(index)});
  }
}

/// The interval that MESSAGE_INTERVAL tells.
std::int32_t told_interval(Ship& s, std::uint16_t id) {
  s.command(mav::kCmdGetMessageInterval, id);
  s.tick();
  CHECK(s.result() == mav::kAccepted);
  const auto bytes = s.links.bytes(0);
  for (std::size_t at = 0; at < bytes.size(); at += 12U + bytes[at + 1]) {
    if (bytes[at + 7] + 256U * bytes[at + 8] != 244) continue;
    std::array<std::uint8_t, 6> payload{};
    std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(at) + 10,
                std::min<std::size_t>(6, bytes[at + 1]), payload.begin());
    CHECK(payload[4] + 256U * payload[5] == id);
    std::int32_t told_us = 0;
    std::memcpy(&told_us, payload.data(), sizeof told_us);
    return told_us;
  }
  FAIL("no MESSAGE_INTERVAL");
  return 0;
}

TEST_CASE("an interval that was accepted is told as it is, however long") {
  Ship s;
  s.tick();
  for (const float us : {1e5F, 1e6F, 6e7F, 1e9F, 2.1e9F, 2.2e9F, 3e9F, 3.6e9F}) {
    s.command(mav::kCmdSetMessageInterval, link::Attitude::kId, us);
    s.tick();
    if (s.result() != mav::kAccepted) continue;
    CAPTURE(us);
    CHECK(told_interval(s, link::Attitude::kId) >= static_cast<double>(std::min(us, 2.14e9F)));
  }
  s.command(mav::kCmdSetMessageInterval, link::Attitude::kId, -1);
  s.tick();
  CHECK(told_interval(s, link::Attitude::kId) == -1);
  CHECK(told_interval(s, 25) == 0);
  s.command(mav::kCmdSetMessageInterval, link::Heartbeat::kId, 1e5F);
  s.tick();
  CHECK(s.result() == mav::kDenied);
  CHECK(told_interval(s, link::Heartbeat::kId) == 1'000'000);
  for (const std::uint16_t id : {link::Odometry::kId, std::uint16_t{25}}) {
    s.command(mav::kCmdSetMessageInterval, id, 1e5F);
    s.tick();
    CHECK(s.result() == mav::kUnsupported);
  }
}

TEST_CASE("who asks before the first tick is told the same as later") {
  Ship early, late;
  late.tick();
  for (Ship* s : {&early, &late}) {
    s->command(mav::kCmdRequestMessage, link::AutopilotVersion::kId);
    s->tick();
    CHECK(s->result() == mav::kAccepted);
  }
  const auto version = [](const Ship& s) {
    const auto bytes = s.links.bytes(0);
    for (std::size_t at = 0; at < bytes.size(); at += 12U + bytes[at + 1]) {
      if (bytes[at + 7] != 148) continue;
      const auto begin = bytes.begin() + static_cast<std::ptrdiff_t>(at) + 10;
      return testing::Bytes(begin, begin + bytes[at + 1]);
    }
    return testing::Bytes();
  };
  REQUIRE_FALSE(version(early).empty());
  CHECK(version(early) == version(late));
}

TEST_CASE("among however many requests of a tick, a disarm is heard and answered") {
  constexpr std::uint32_t kSeed = 61;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (int round = 0; round < 60; ++round) {
    Ship s;
    s.bring_to(State::kFormation);
    const auto many = static_cast<unsigned>(1 + random() % 100);
    const auto at = static_cast<unsigned>(random() % many);
    for (unsigned k = 0; k < many; ++k) {
      if (k == at) {
        s.command(mav::kCmdComponentArmDisarm, 0, 0,
                  {1, k % 2 == 0 ? std::uint8_t{0} : std::uint8_t{1}});
      } else {
        s.ask(link::Ping{k, k, {}});
      }
    }
    s.tick();
    CAPTURE(many);
    CAPTURE(at);
    CHECK(s.state() == State::kDisarmed);
    CHECK(s.result() == mav::kAccepted);
    CHECK(s.counters.requests_dropped == (many > 24 ? many - 24 : 0));
  }
}

TEST_CASE("pings, clocks and missions are answered to who asked, on his link alone") {
  Ship s;
  s.tick();
  const std::int64_t read_us = s.now_us;
  s.ask(link::Ping{123, 9, {}}, 1);
  s.ask(link::Ping{123, 10, {255, 190}}, 1);  // an answer, and not ours
  s.ask(link::Timesync{0, 42}, 1);
  s.ask(link::MissionRequestList{{1, 1}, 1}, 1);
  s.ask(link::MissionRequestList{{1, 1}, 0}, 1);
  s.tick();
  const auto pings = s.all<link::Ping>(1);
  REQUIRE(pings.size() == 1);
  CHECK(pings[0].seq == 9);
  CHECK(pings[0].time_usec == 123);
  CHECK(pings[0].target == link::Address{255, 190});
  const auto counts = s.all<link::MissionCount>(1);
  REQUIRE(counts.size() == 2);
  CHECK(counts[0].count == 0);
  CHECK(counts[0].mission_type == 1);
  CHECK(counts[1].mission_type == 0);
  CHECK(counts[0].target == link::Address{255, 190});
  int times = 0;
  for (const auto& t : s.all<link::Timesync>(1)) {
    if (t.tc1 == 0) continue;
    ++times;
    CHECK(t.ts1 == 42);
    CHECK(t.tc1 == read_us * 1000);
    CHECK(t.target == link::Address{255, 190});
  }
  CHECK(times == 1);
  CHECK(s.all<link::Ping>(0).empty());
  CHECK(s.all<link::MissionCount>(0).empty());
  s.ask(link::MissionRequest{{1, 1}, 0, 1}, 1);
  s.ask(link::MissionRequestInt{{1, 1}, 0, 1}, 1);
  s.ask(link::MissionItem{{1, 1}, 1}, 1);
  link::MissionItemInt unknown{};
  unknown.target = {1, 1};
  unknown.mission_type = 3;
  s.ask(unknown, 1);
  s.ask(link::LogRequestList{{1, 1}, 0, 0xFFFF}, 1);
  s.ask(link::LogRequestList{{2, 1}, 0, 0xFFFF}, 1);
  const auto not_sent = s.counters.mavlink_not_sent;
  s.tick();
  CHECK(s.counters.mavlink_not_sent == not_sent);
  // Of the answers, MISSION_ACK and LOG_ENTRY, boats read none.
  const auto& told = s.heard[1];
  CHECK(std::ranges::count(told, std::uint32_t{link::MissionAck::kId}, &link::Received::id) == 4);
  CHECK(std::ranges::count(told, std::uint32_t{link::LogEntry::kId}, &link::Received::id) == 1);
}

// States.

TEST_CASE("a disarm leads out of every state, and an operator's heartbeat tells of it at once") {
  for (const State from : kEveryState) {
    Ship s;
    s.bring_to(from);
    s.command(mav::kCmdComponentArmDisarm, 0, from == State::kHold ? 21196.0F : 0.0F);
    s.tick();
    CHECK(s.state() == State::kDisarmed);
    CHECK(s.result() == mav::kAccepted);
    if (from == State::kDisarmed) continue;
    for (const std::size_t link : {0U, 1U}) {
      REQUIRE(s.all<link::Heartbeat>(link).size() == 1);
      CHECK(s.all<link::Heartbeat>(link)[0].base_mode == 1);
      CHECK(s.all<link::Heartbeat>(link)[0].system_status == 3);
      CHECK(s.says("DISARMED", link));
    }
  }
}

TEST_CASE("every state has its heartbeat") {
  const std::array<std::array<unsigned, 3>, core::kStates> kExpected{{{1, 4, 3},
                                                                      {129, 4, 4},
                                                                      {193, 0, 4},
                                                                      {141, 6, 4},
                                                                      {141, 6, 5},
                                                                      {131, 4, 4},
                                                                      {1, 4, 6},
                                                                      {141, 10, 4},
                                                                      {141, 15, 4},
                                                                      {141, 5, 4},
                                                                      {141, 11, 4}}};
  for (const State state : kEveryState) {
    Ship s;
    s.bring_to(state);
    s.command(mav::kCmdRequestMessage, link::Heartbeat::kId);
    s.tick();
    REQUIRE(s.all<link::Heartbeat>().size() >= 1);
    const auto beat_now = s.all<link::Heartbeat>()[0];
    const auto& [base, mode, status] = kExpected[static_cast<std::size_t>(state)];
    CAPTURE(static_cast<int>(state));
    CHECK(beat_now.base_mode == base);
    CHECK(beat_now.custom_mode == mode);
    CHECK(beat_now.system_status == status);
    CHECK(beat_now.type == 11);
    CHECK(beat_now.autopilot == 0);
  }
}

TEST_CASE("termination leads to FAULT from every state, and only a disarm out of it") {
  for (const State from : kEveryState) {
    Ship s;
    s.bring_to(from);
    s.command(mav::kCmdDoFlightTermination, 1);
    s.tick();
    CHECK(s.state() == State::kFault);
    CHECK(s.result() == mav::kAccepted);
    if (from != State::kFault) {
      CHECK(s.says("terminated"));
      CHECK(s.all<link::Statustext>()[0].severity == mav::kSeverityCritical);
    }
    s.sticks(0, 0);
    for (const float mode : {0.0F, 4.0F, 6.0F}) s.command(mav::kCmdDoSetMode, 1, mode);
    s.command(mav::kCmdComponentArmDisarm, 1, 21196);
    s.command(mav::kCmdDoFlightTermination, 0);
    s.test_port();
    s.tick();
    const auto acks = s.all<link::CommandAck>();
    CHECK(acks.size() == 6);
    for (const auto& ack : acks) CHECK(ack.result != mav::kAccepted);
    CHECK(s.state() == State::kFault);
    s.pass(30);
    CHECK(s.state() == State::kFault);
    s.command(mav::kCmdComponentArmDisarm, 0);
    s.tick();
    CHECK(s.state() == State::kDisarmed);
  }
}

TEST_CASE("the host's disarm comes after whatever else was asked in that tick") {
  for (const State from : kEveryState) {
    Ship s;
    s.bring_to(from);
    s.vehicle->disarm();
    s.command(mav::kCmdComponentArmDisarm, 1);
    s.command(mav::kCmdDoSetMode, 1, 6);
    s.tick();
    CHECK(s.state() == State::kDisarmed);
    s.tick();
    CHECK(s.state() == State::kDisarmed);
    if (from == State::kFault) continue;
    s.command(mav::kCmdComponentArmDisarm, 1);  // it held for one tick
    s.tick();
    CHECK(s.state() == State::kHold);
  }
}

TEST_CASE("sticks count for half a second, only whole ones, only the one commander's") {
  Parameters p;
  p.MAV_GCS_SYSID = 255;
  Ship s(p);
  const auto fresh = [&](std::int64_t after_us) {
    return (s.conditions(s.now_us + after_us) & core::kSticksFresh) != 0;
  };
  CHECK_FALSE(fresh(0));
  s.hear(s.stranger, link::ManualControl{500, 0, 0, 0, 0, 1});
  s.hear(s.stranger, link::ManualControl{500, 0, 0, 0, 0, 0});
  CHECK_FALSE(fresh(0));
  s.sticks(-250, 750);
  CHECK(fresh(499'999));
  CHECK_FALSE(fresh(500'000));
  CHECK(s.supervisor.sticks().surge == doctest::Approx(-0.25));
  CHECK(s.supervisor.sticks().yaw == doctest::Approx(0.75));
  s.now_us += 400'000;
  s.sticks(32767, 0);
  s.sticks(0, -1001);
  CHECK(s.counters.mavlink_bad_value == 2);
  CHECK(s.supervisor.sticks().surge == doctest::Approx(-0.25));
  CHECK_FALSE(fresh(100'000));
  s.ask(link::ManualControl{100, INT16_MAX, INT16_MAX, 100, UINT16_MAX, 0});  // for a fleet
  CHECK(s.supervisor.sticks().surge == doctest::Approx(-0.25));
  CHECK_FALSE(fresh(100'000));
  s.ask(link::ManualControl{100, INT16_MAX, INT16_MAX, 100, UINT16_MAX, 1});
  CHECK(s.supervisor.sticks().surge == doctest::Approx(0.1));
  s.ask(link::ManualControl{900, 0, 0, 0, 0, 2});  // for another boat
  CHECK(s.supervisor.sticks().surge == doctest::Approx(0.1));
}

TEST_CASE("whoever holds the sticks keeps them until he lets go for half a second") {
  Ship s;
  link::MavlinkEncoder mate{{255, 191}};
  s.sticks(100, 0);
  for (int k = 0; k < 100; ++k) {
    s.now_us += 490'000;
    s.hear(s.stranger, link::ManualControl{900, 0, 0, 0, 0, 1});
    s.hear(mate, link::ManualControl{-900, 0, 0, 0, 0, 1}, 1);
    REQUIRE(s.supervisor.sticks().surge == doctest::Approx(0.1));
    s.sticks(100, 0);
  }
  s.now_us += 499'999;
  s.hear(s.stranger, link::ManualControl{900, 0, 0, 0, 0, 1});
  CHECK(s.supervisor.sticks().surge == doctest::Approx(0.1));
  s.now_us += 1;
  s.hear(s.stranger, link::ManualControl{900, 0, 0, 0, 0, 1});
  CHECK(s.supervisor.sticks().surge == doctest::Approx(0.9));
  s.sticks(100, 0);
  CHECK(s.supervisor.sticks().surge == doctest::Approx(0.9));
}

TEST_CASE("a companion that drives holds when the whole system is told to, one at rest is silent") {
  Parameters p;
  p.MAV_IDENTITY = 1;
  p.MAV_COMPID = 191;
  Ship s(p);
  s.tick();
  s.command(mav::kCmdDoSetMode, 1, 4, {1, 0});
  s.tick();
  CHECK(s.all<link::CommandAck>().empty());  // the autopilot's answer is the one that counts
  CHECK(s.all<link::Statustext>().empty());
  s.command(mav::kCmdComponentArmDisarm, 1, 0, {1, 191});
  s.command(mav::kCmdDoSetMode, 1, 6, {1, 191});
  s.tick();
  REQUIRE(s.state() == State::kFormation);
  s.command(mav::kCmdDoSetMode, 1, 4, {1, 0});
  s.tick();
  CHECK(s.state() == State::kHold);
}

TEST_CASE("a companion has no sticks: they are the autopilot's") {
  Parameters p;
  p.MAV_IDENTITY = 1;
  p.MAV_COMPID = 191;
  Ship s(p);
  s.sticks(500, 0);
  CHECK((s.conditions(s.now_us) & core::kSticksFresh) == 0);
}

TEST_CASE("silent sticks end MANUAL in HOLD") {
  Ship s;
  s.bring_to(State::kManual);
  s.pass(0.48);
  CHECK(s.state() == State::kManual);
  s.pass(0.03);
  CHECK(s.state() == State::kHold);
  s.sticks(0, 0);
  s.pass(0.1);
  CHECK(s.state() == State::kHold);
}

TEST_CASE(
    "a motor test begins in HOLD only, ends by itself, and repeating it does not lengthen it") {
  for (const State from : kEveryState) {
    if (from == State::kTest) continue;
    Ship s;
    s.bring_to(from);
    s.test_port();
    s.tick();
    CHECK((s.result() == mav::kAccepted) == (from == State::kHold));
    CHECK((s.state() == State::kTest) == (from == State::kHold));
    CHECK(s.supervisor.motor_test().has_value() == (from == State::kHold));
  }
  Ship s;
  s.bring_to(State::kHold);
  s.test_port(5, 2);
  int ticks = 0;
  for (s.tick(); s.state() == State::kTest; s.tick()) {
    if (++ticks % 20 == 0) s.test_port(5, 2, static_cast<std::uint8_t>(ticks / 20));
    REQUIRE(ticks < 1000);
  }
  CHECK(ticks == 200);
  CHECK(s.state() == State::kHold);
}

TEST_CASE("a refusal is said once for each failing check, and not more often than twice a second") {
  Ship s;
  s.world = kFair & ~(core::kSoleVessel | core::kEscsOnline | core::kParametersSaved |
                      core::kSoleController);
  s.tick();
  int said = 0;
  for (int k = 0; k < 200; ++k) {
    s.command(mav::kCmdComponentArmDisarm, 1);
    s.tick();
    CHECK(s.result() == mav::kTemporarilyRejected);
    const auto texts = s.all<link::Statustext>();
    if (texts.empty()) continue;
    ++said;
    CHECK(texts.size() == 4);
    CHECK(s.says("PreArm: system id"));
    CHECK(s.says("PreArm: ESCs"));
    CHECK(s.says("PreArm: parameters"));
    CHECK(s.says("PreArm: another controller"));
    for (const auto& t : texts) CHECK(t.severity == mav::kSeverityWarning);
  }
  CHECK(said == 4);
  CHECK(s.state() == State::kDisarmed);
}

TEST_CASE("where FORMATION lacks something a boat is armed all the same, and that is told once") {
  constexpr core::Conditions kMayLack =
      core::kOwn | core::kOwnTimed | core::kOwnPrompt | core::kLimits | core::kFollows;
  for (unsigned bit = 0; bit < core::kConditionCount; ++bit) {
    if ((kMayLack >> bit & 1U) == 0) continue;
    Ship s;
    s.world = kFair & ~(core::Conditions{1} << bit);
    s.tick();
    s.command(mav::kCmdComponentArmDisarm, 1);
    s.tick();
    CHECK(s.result() == mav::kAccepted);
    const std::string why(complaint_of(core::Conditions{1} << bit));
    CHECK(s.says("HOLD"));
    CHECK(s.says("armed, no FORMATION: " + why.substr(0, 20)));
    s.command(mav::kCmdComponentArmDisarm, 1);
    s.tick();
    CHECK(s.all<link::Statustext>().empty());
    s.command(mav::kCmdDoSetMode, 1, 6);
    s.tick();
    CHECK(s.result() == mav::kTemporarilyRejected);
    CHECK(s.says("Refused: " + why));
    CHECK(s.state() == State::kHold);
  }
}

TEST_CASE("an armed boat whose sticks are not at neutral says so once as MANUAL begins") {
  for (const std::int16_t surge : {std::int16_t{0}, std::int16_t{1000}}) {
    Ship s;
    s.bring_to(State::kHold);
    s.sticks(surge, 0);
    s.command(mav::kCmdDoSetMode, 1, 0);
    s.tick();
    CHECK(s.state() == State::kManual);
    CHECK(s.says("MANUAL: centre the sticks first") == (surge != 0));
    s.sticks(surge, 0);
    s.tick();
    CHECK(s.all<link::Statustext>().empty());
  }
}

TEST_CASE("a refusal with every reason there is leaves the heartbeat its room") {
  Ship s;
  s.world = 0;
  s.links.signing().start({1, 2, 3}, 1, 0);
  s.links.set_policy(0, SigningPolicy::kAccept);
  for (std::uint32_t k = 0; k < 23; ++k) s.ask(link::Ping{k, k, {}});
  s.command(mav::kCmdComponentArmDisarm, 1);
  s.tick();
  CHECK(s.all<link::Statustext>().size() > 0);
  CHECK(s.all<link::Heartbeat>().size() == 1);
  CHECK(s.counters.mavlink_not_sent == 0);
}

// Who may.

TEST_CASE("where one ground station commands, no other does; all may read and stop") {
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
  CHECK(errors >= 1);  // PARAM_ERROR is none of what we read
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

TEST_CASE("what is meant for others is neither done nor answered") {
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

TEST_CASE("a companion leaves to the autopilot what is asked of the whole system, but for stops") {
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

TEST_CASE(
    "a companion speaks under its autopilot's id once it knows it, and says that it changed") {
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

TEST_CASE("no parameter changes the mode, whatever file a client loads") {
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
  CHECK(s.says("MODE is no parameter of this boat"));
  CHECK(s.vehicle->take_save_request() == SaveRequest::kNone);
}

TEST_CASE("a parameter that was set is a change once, and a request to save it, once") {
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

TEST_CASE("what an operator confirms is more than what he changed, in either order") {
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

// Telling.

TEST_CASE(
    "a sentence of any length comes whole to every link, in chunks as the protocol has them") {
  std::uint16_t last_id = 0;
  Ship s(Parameters{}, 3);
  for (std::size_t length = 0; length <= 200; ++length) {
    std::string sentence;
    for (std::size_t k = 0; k < length; ++k) sentence += static_cast<char>('a' + k % 23);
    s.vehicle->begin(s.now_us, kTick_us);
    const std::size_t cut = length / 3;
    s.vehicle->send_statustext(
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

TEST_CASE("an endless sentence is cut off, not a crash") {
  Ship s;
  s.vehicle->begin(s.now_us, kTick_us);
  s.vehicle->send_statustext(5, {std::string(500, 'x'), std::string(500, 'y')}, s.counters);
  std::string whole;
  for (const auto& r : received_from(s.decoders[0], s.links.bytes(0), s.counters)) {
    whole += text_of(std::get<link::Statustext>(r.message));
  }
  CHECK(whole == std::string(200, 'x'));
}

TEST_CASE("heartbeats and requests for the time leave once a second on every link") {
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
  for (int k = 0; k < 2500; ++k) {  // what link 0 sends comes back on link 1
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

TEST_CASE("what names another is handed on unchanged to where he was heard") {
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

TEST_CASE("what is no request and nothing of the vehicle's is left to the boat") {
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

TEST_CASE("a limited link hears the state before all else, and keeps to its limit") {
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
