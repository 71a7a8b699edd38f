// SPDX-License-Identifier: MIT
// A vehicle answers each request, to its sender, in order.
#include <array>
#include <random>

#include "app/every_id.hpp"
#include "app/operator/ship.hpp"

namespace flotilla::app {
namespace {

TEST_CASE("every requested message follows its one ACK, in the same tick") {
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

TEST_CASE("unknown messages are unsupported; messages without data yet come later") {
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

/// The ticks, among the next `ticks`, in which the reference was sent.
std::vector<int> references(Ship& s, int ticks, const std::function<bool(int)>& is_news) {
  std::vector<int> told;
  for (int k = 0; k < ticks; ++k) {
    if (is_news(k)) ++s.news;
    s.tick();
    if (!s.all<link::FormationReference>().empty()) told.push_back(k);
  }
  return told;
}

TEST_CASE("the reference is sent ten times a second, new or not, on every link") {
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

TEST_CASE(
    "a new reference is relayed at once, up to half an interval early, never at twice the rate") {
  Ship s;
  s.pass(1);
  while (references(s, 1, [](int) { return false; }).empty()) {
  }
  // The next one is due in ten ticks; from here on news comes three ticks before each is due.
  const auto told = references(s, 200, [](int k) { return k % 10 == 6; });
  REQUIRE(told.size() == 20);
  for (const int k : told) CHECK(k % 10 == 6);
}

TEST_CASE("with SR_STATE 2 the reference is sent four times a second, with 0 never") {
  for (const auto& [rate, times] : {std::pair{2.0F, 40U}, {0.0F, 0U}, {100.0F, 100U}}) {
    Parameters p;
    p.SR_STATE = rate;
    Ship s(p);
    s.pass(1);
    CHECK(references(s, 1000, [](int) { return false; }).size() == times);
  }
}

TEST_CASE("a set parameter is in force before any later request is handled") {
  Ship s;
  s.tick();
  s.set("MAV_GCS_SYSID", 99);
  s.command(mav::kCmdComponentArmDisarm, 1);  // from system 255
  s.set("LAW_KX", 0.5F);                      // also from system 255
  s.vehicle->begin(s.now_us, kTick_us);
  s.vehicle->apply_conditions(s.world, s.counters);
  CHECK(s.vehicle->answer(s.counters));  // more requests are pending; the change comes first:
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

TEST_CASE("with any number of parameters set in a tick, all requests are answered, in order") {
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
  for (std::size_t k = 0; k < acks.size(); ++k) {
    const bool behind_stop = k == 2 || k == 4;  // an arming
    CHECK(acks[k].result == (behind_stop ? mav::kTemporarilyRejected : mav::kAccepted));
  }
  CHECK(s.state() == State::kDisarmed);
  CHECK(s.vehicle->parameters().LAW_KX == 0.375F);
}

TEST_CASE("a disarm behind any flood of requests is answered in the next tick") {
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
      for (int k = 0; k < 5; ++k) {  // an earlier arming that found no room does not undo it
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

/// The interval in MESSAGE_INTERVAL.
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

TEST_CASE("an accepted interval is reported as it is, however long") {
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

TEST_CASE("a request before the first tick gets the same answer as later") {
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

TEST_CASE("a disarm among any number of requests in a tick is obeyed and answered") {
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

TEST_CASE("pings, TIMESYNC and mission requests are answered to their sender, on his link alone") {
  Ship s;
  s.tick();
  const std::int64_t read_us = s.now_us;
  s.ask(link::Ping{123, 9, {}}, 1);
  s.ask(link::Ping{123, 10, {255, 190}}, 1);  // an answer, not a request to us
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

}  // namespace
}  // namespace flotilla::app
