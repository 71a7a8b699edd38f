// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <random>

#include "app/operator/telemetry/streams.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;
constexpr std::int64_t kTick_us = 10'000, kSecond_us = 1'000'000;
constexpr std::size_t kLinks = 4;

struct Room {
  std::array<Streams::Link, kLinks> links;
};

Configuration with_start(const Parameters& p, bool companion, std::int64_t tick_us) {
  Configuration out = configuration_of(p);
  out.start.companion = companion;
  out.start.tick_us = tick_us;
  return out;
}

struct RoomyStreams : Room, Streams {
  RoomyStreams(const Parameters& p, bool companion, std::int64_t tick_us)
      : Streams(with_start(p, companion, tick_us), links) {}
  RoomyStreams(const RoomyStreams&) = delete;
  RoomyStreams& operator=(const RoomyStreams&) = delete;
};

std::size_t index_of(std::uint16_t id) {
  for (std::size_t i = 0; i < kStreams.size(); ++i) {
    if (kStreams[i].id == id) return i;
  }
  FAIL("no such stream");
  return 0;
}

/// Number of messages sent on that link at a steady tick.
std::int64_t sent(Streams& streams, std::size_t stream, std::size_t link, std::int64_t from_us,
                  std::int64_t for_us, std::int64_t tick_us = kTick_us) {
  std::int64_t count = 0;
  for (std::int64_t now = from_us; now < from_us + for_us; now += tick_us) {
    count += streams.schedule(stream, link).take_if_due(now) ? 1 : 0;
  }
  return count;
}

TEST_CASE("a link without requests gets the default streams") {
  const std::map<std::uint16_t, std::int32_t> kDefaults{
      {link::Attitude::kId, 100'000},
      {link::LocalPositionNed::kId, 100'000},
      {link::FormationReference::kId, 100'000},
      {link::FormationFuture::kId, 100'000},
      {link::FollowTarget::kId, -1},
      {link::GpsGlobalOrigin::kId, 1'000'000},
      {link::GlobalPositionInt::kId, 500'000},
      {link::SysStatus::kId, 1'000'000},
      {link::SystemTime::kId, 1'000'000},
      {link::CurrentMode::kId, -1},
      {link::MissionCurrent::kId, 1'000'000},
      {link::FenceStatus::kId, 1'000'000},
      {link::HomePosition::kId, 2'000'000},
      {link::GpsRawInt::kId, 1'100'000},
      {link::VfrHud::kId, 900'000},
      {link::NavControllerOutput::kId, 1'000'000},
      {link::PositionTargetLocalNed::kId, 1'000'000},
      {link::MavEscStatus::kId, -1},
      {link::MavEscInfo::kId, -1},
      {link::BatteryStatus::kId, 5'000'000},
      {link::NamedValueFloat::kId, 1'000'000},
      {link::ExtendedSysState::kId, -1},
      {link::Heartbeat::kId, 1'000'000}};
  RoomyStreams streams(Parameters{}, false, kTick_us);
  for (std::size_t link = 0; link < kLinks; ++link) {
    for (unsigned id = 0; id <= UINT16_MAX; ++id) {
      const auto found = kDefaults.find(static_cast<std::uint16_t>(id));
      CAPTURE(id);
      REQUIRE(streams.interval_us(link, static_cast<std::uint16_t>(id)) ==
              (found == kDefaults.end() ? 0 : found->second));
    }
    for (std::size_t stream = 0; stream < kStreams.size(); ++stream) {
      const std::int32_t interval_us = kDefaults.at(kStreams[stream].id);
      CHECK(sent(streams, stream, link, 0, 20 * kSecond_us) ==
            (interval_us < 0 ? 0 : (20 * kSecond_us + interval_us - 1) / interval_us));
    }
  }
}

TEST_CASE(
    "beside an autopilot the boat sends only streams that cannot be mistaken for the autopilot's") {
  RoomyStreams streams(Parameters{}, true, kTick_us);
  for (std::size_t stream = 0; stream < kStreams.size(); ++stream) {
    const std::uint16_t id = kStreams[stream].id;
    const bool may = id == link::CurrentMode::kId || id == link::MavEscStatus::kId ||
                     id == link::MavEscInfo::kId || id == link::NamedValueFloat::kId ||
                     id == link::FormationReference::kId || id == link::FormationFuture::kId;
    CAPTURE(id);
    CHECK(is_sent_by_companion(id) == may);
    const bool asked = kStreams[stream].pace == Pace::kOnRequest;
    CHECK((streams.interval_us(0, id) != 0) == may);
    CHECK((sent(streams, stream, 0, 0, 10 * kSecond_us) > 0) == (may && !asked));
    CHECK(streams.set(1, id, kSecond_us, 0) == may);
    CHECK((sent(streams, stream, 1, 0, 10 * kSecond_us) > 0) == may);
  }
  CHECK_FALSE(is_sent_by_companion(link::Odometry::kId));
  CHECK(is_sent_by_companion(link::AvailableModes::kId));
}

TEST_CASE("intervals are set for each link: −1 none, 0 the default, otherwise as requested") {
  for (std::size_t stream = 0; stream < kStreams.size(); ++stream) {
    const std::uint16_t id = kStreams[stream].id;
    RoomyStreams streams(Parameters{}, false, kTick_us);
    const std::int32_t before_us = streams.interval_us(1, id);
    REQUIRE(streams.set(1, id, 250'000, 0));
    CHECK(streams.interval_us(1, id) == 250'000);
    CHECK(sent(streams, stream, 1, 0, 10 * kSecond_us) == 40);
    for (const std::size_t other : {0U, 2U, 3U}) CHECK(streams.interval_us(other, id) == before_us);
    REQUIRE(streams.set(1, id, -1, 0));
    CHECK(streams.interval_us(1, id) == -1);
    CHECK(sent(streams, stream, 1, 0, 10 * kSecond_us) == 0);
    REQUIRE(streams.set(1, id, 0, 0));
    CHECK(streams.interval_us(1, id) == before_us);
  }
}

TEST_CASE("no stream can be requested of ODOMETRY, HEARTBEAT, or an unknown message") {
  RoomyStreams streams(Parameters{}, false, kTick_us);
  for (unsigned id = 0; id <= UINT16_MAX; ++id) {
    bool is_stream = false;
    for (const StreamInfo& info : kStreams) is_stream = is_stream || info.id == id;
    REQUIRE(streams.set(0, static_cast<std::uint16_t>(id), kSecond_us, 0) == is_stream);
  }
  CHECK(streams.interval_us(0, link::Heartbeat::kId) == 1'000'000);
  CHECK(streams.interval_us(0, link::Odometry::kId) == 0);
}

TEST_CASE("a rate above that of the tick or the link becomes the fastest possible") {
  constexpr std::uint32_t kSeed = 5;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  const auto any = [&](std::int64_t least, std::int64_t most) {
    return std::uniform_int_distribution(least, most)(random);
  };
  for (int k = 0; k < 3000; ++k) {
    const std::int64_t tick_us = any(1000, 20'000);
    RoomyStreams streams(Parameters{}, false, tick_us);
    const StreamInfo& info = kStreams[random() % kStreams.size()];
    const std::uint32_t rate_Bps =
        random() % 3 == 0 ? 0 : static_cast<std::uint32_t>(any(1, 20'000));
    const std::int64_t asked_us = any(1, 2'000'000);
    REQUIRE(streams.set(0, info.id, asked_us, rate_Bps));
    const std::int64_t got_us = streams.interval_us(0, info.id);
    const double carried_us = rate_Bps == 0 ? 0 : info.bytes * 1e6 / rate_Bps;
    CAPTURE(info.id);
    REQUIRE(got_us >= asked_us);
    REQUIRE(got_us >= tick_us);
    REQUIRE(double(got_us) > carried_us - 1);
    REQUIRE(double(got_us) <=
            std::max({double(asked_us), double(tick_us), carried_us}));  // not slower than need be
  }
}

TEST_CASE("at any tick rate as many messages are sent as the interval says, never two at once") {
  constexpr std::uint32_t kSeed = 6;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  const auto any = [&](std::int64_t least, std::int64_t most) {
    return std::uniform_int_distribution(least, most)(random);
  };
  for (int k = 0; k < 200; ++k) {
    const std::int64_t tick_us = any(1000, 20'000);
    const std::int64_t interval_us = tick_us + any(0, 500'000);
    RoomyStreams streams(Parameters{}, false, tick_us);
    REQUIRE(streams.set(2, link::Attitude::kId, interval_us, 0));
    const auto count =
        sent(streams, index_of(link::Attitude::kId), 2, any(0, 1000), 30 * kSecond_us, tick_us);
    CAPTURE(tick_us);
    CAPTURE(interval_us);
    CHECK(std::abs(double(count) - 30e6 / double(interval_us)) < 2);  // the first, half a tick
  }
}

TEST_CASE("a new SR_STATE or SR_SLOW changes streams at that rate, not those set by a client") {
  Parameters p;
  RoomyStreams streams(p, false, kTick_us);
  REQUIRE(streams.set(1, link::Attitude::kId, 40'000, 0));
  REQUIRE(streams.set(1, link::NavControllerOutput::kId, -1, 0));
  p.SR_STATE = 50;
  p.SR_SLOW = 4;
  streams.configure(configuration_of(p).operators);
  CHECK(streams.interval_us(0, link::Attitude::kId) == 20'000);
  CHECK(streams.interval_us(0, link::LocalPositionNed::kId) == 20'000);
  CHECK(streams.interval_us(0, link::NavControllerOutput::kId) == 250'000);
  CHECK(streams.interval_us(0, link::NamedValueFloat::kId) == 250'000);
  CHECK(streams.interval_us(0, link::SysStatus::kId) == 1'000'000);
  CHECK(streams.interval_us(0, link::FollowTarget::kId) == -1);
  CHECK(streams.interval_us(1, link::Attitude::kId) == 40'000);
  CHECK(streams.interval_us(1, link::NavControllerOutput::kId) == -1);
  CHECK(sent(streams, index_of(link::Attitude::kId), 0, 0, kSecond_us) == 50);
  p.SR_STATE = p.SR_SLOW = 0;
  streams.configure(configuration_of(p).operators);
  CHECK(streams.interval_us(0, link::Attitude::kId) == -1);
  CHECK(streams.interval_us(0, link::NavControllerOutput::kId) == -1);
  CHECK(sent(streams, index_of(link::Attitude::kId), 0, 0, kSecond_us) == 0);
}

TEST_CASE("an SR_SLOW below 1 slows streams with a rate of their own; no other SR_SLOW does") {
  Parameters p;
  RoomyStreams streams(p, false, kTick_us);
  const auto interval_us = [&](float rate_Hz, std::uint16_t id) {
    p.SR_SLOW = rate_Hz;
    streams.configure(configuration_of(p).operators);
    return streams.interval_us(0, id);
  };
  for (const StreamInfo& info : kStreams) {
    CAPTURE(info.id);
    const bool fixed = info.pace == Pace::kFixed;
    const bool slow = info.pace == Pace::kSlow;
    const std::int32_t own_us = interval_us(1, info.id);
    CHECK(interval_us(0.25F, info.id) ==
          (fixed || slow ? std::max<std::int32_t>(own_us, 4'000'000) : own_us));
    CHECK(interval_us(20, info.id) == (slow ? 50'000 : own_us));
    CHECK(interval_us(0, info.id) == (slow ? -1 : own_us));
  }
  p.SR_SLOW = 0.25F;
  streams.configure(configuration_of(p).operators);
  CHECK(streams.slowed_us(0, kSecond_us) == 4 * kSecond_us);
}

TEST_CASE("a link limited to 57,600 Bd gets the position every second, other telemetry every 4 s") {
  Parameters p;
  RoomyStreams streams(p, false, kTick_us), wide(p, false, kTick_us);
  for (const std::uint32_t bytes_per_s : {5'760U, 1'000U, 5'761U, 0U}) {
    streams.limit(1, bytes_per_s);
    const bool narrow = bytes_per_s != 0 && bytes_per_s <= 5'760;
    for (const StreamInfo& info : kStreams) {
      CAPTURE(info.id);
      const std::int32_t own_us = wide.interval_us(1, info.id);
      const bool slowed = narrow && (info.pace == Pace::kSlow || info.pace == Pace::kFixed);
      const std::int32_t least_us = info.id == link::GlobalPositionInt::kId ? 1'000'000 : 4'000'000;
      CHECK(streams.interval_us(0, info.id) == own_us);
      CHECK(streams.interval_us(1, info.id) == (slowed ? std::max(own_us, least_us) : own_us));
    }
    CHECK(streams.slowed_us(1, kSecond_us) == (narrow ? 4 : 1) * kSecond_us);
  }
  streams.limit(1, 1'000);
  for (const float rate_Hz : {0.0F, 0.1F, 20.0F}) {
    p.SR_SLOW = rate_Hz;
    streams.configure(configuration_of(p).operators);
    wide.configure(configuration_of(p).operators);
    const std::int32_t own_us = wide.interval_us(1, link::NamedValueFloat::kId);
    const std::int32_t us = streams.interval_us(1, link::NamedValueFloat::kId);
    CHECK(us == (own_us > 0 ? std::max(own_us, 4'000'000) : own_us));
    CHECK(streams.interval_us(1, link::GlobalPositionInt::kId) ==
          (rate_Hz == 0.1F ? 10 : 1) * 1'000'000);
  }
  streams.set(1, link::NamedValueFloat::kId, 500'000, 0);
  CHECK(streams.interval_us(1, link::NamedValueFloat::kId) == 500'000);
}

TEST_CASE("parameters set to the same value shift no stream's schedule") {
  RoomyStreams streams(Parameters{}, false, kTick_us);
  const std::size_t battery = index_of(link::BatteryStatus::kId);
  CHECK(sent(streams, battery, 0, 0, kTick_us) == 1);
  for (std::int64_t now = kTick_us; now < 5 * kSecond_us - kTick_us; now += kTick_us) {
    streams.configure(configuration_of({}).operators);
    REQUIRE_FALSE(streams.schedule(battery, 0).take_if_due(now));
  }
}

TEST_CASE("the slowest rates that parameters allow are reported correctly, or as none") {
  for (const float rate_Hz : {1e-3F, 5e-4F, 3e-4F, 1e-4F, 1e-6F}) {
    Parameters p;
    p.SR_SLOW = rate_Hz;
    RoomyStreams streams(p, false, kTick_us);
    const double told_us = streams.interval_us(0, link::NamedValueFloat::kId);
    CAPTURE(rate_Hz);
    CHECK((told_us == -1 || told_us >= std::min(0.99e6 / double{rate_Hz}, double{INT32_MAX})));
  }
}

TEST_CASE("an urgent message is sent at once on every link that has it, then on schedule") {
  RoomyStreams streams(Parameters{}, false, kTick_us);
  const std::size_t mode = index_of(link::CurrentMode::kId);
  for (std::size_t link = 0; link < 3; ++link) {
    REQUIRE(streams.set(link, link::CurrentMode::kId, 2 * kSecond_us, 0));
  }
  for (std::size_t link = 0; link < kLinks; ++link) sent(streams, mode, link, 0, kSecond_us);
  streams.make_due(link::CurrentMode::kId);
  for (std::size_t link = 0; link < 3; ++link) {
    CHECK(streams.schedule(mode, link).take_if_due(kSecond_us));
    CHECK_FALSE(streams.schedule(mode, link).take_if_due(kSecond_us + kTick_us));
    CHECK(streams.schedule(mode, link).take_if_due(3 * kSecond_us));
  }
  CHECK_FALSE(streams.schedule(mode, 3).take_if_due(kSecond_us));
  streams.make_due(9999);  // no such stream
}

/// Rate of messages on a link over 100 s, as a share of ten a second.
struct Rates {
  RoomyStreams streams{Parameters{}, false, kTick_us};
  std::int64_t now_us = 0;

  double of(std::uint16_t id, std::size_t link) {
    now_us += 1000 * kSecond_us;
    const auto count = sent(streams, index_of(id), link, now_us, 100 * kSecond_us);
    return static_cast<double>(count) / 1000;
  }
  void hear(std::uint8_t percent, std::size_t link = 1) {
    streams.radio_has_room(link, percent, now_us);
  }
};

TEST_CASE(
    "a radio whose buffer fills reduces its link's telemetry to a twentieth, then restores it") {
  constexpr std::uint16_t kSlow = link::MavEscStatus::kId;
  Rates rates;
  for (const std::size_t link : {0U, 1U}) REQUIRE(rates.streams.set(link, kSlow, 100'000, 0));
  CHECK(rates.of(kSlow, 1) == doctest::Approx(1).epsilon(0.01));
  double share = 1;
  for (int k = 0; k < 40; ++k) {
    const auto percent = static_cast<std::uint8_t>(k % 2 == 0 ? 24 : 34);
    share = std::max(0.05, share * (percent == 24 ? 0.8 : 0.975));
    rates.hear(percent);
    REQUIRE(rates.of(kSlow, 1) == doctest::Approx(share).epsilon(0.02));
  }
  CHECK(rates.of(kSlow, 1) == doctest::Approx(0.05).epsilon(0.02));
  CHECK(rates.of(kSlow, 0) == doctest::Approx(1).epsilon(0.01));
  CHECK(rates.streams.interval_us(1, kSlow) == 100'000);
  for (const std::uint8_t neither : std::initializer_list<std::uint8_t>{35, 50, 101, 255})
    rates.hear(neither);
  CHECK(rates.of(kSlow, 1) == doctest::Approx(0.05).epsilon(0.02));
  for (int k = 0; k < 60; ++k) rates.hear(51);
  CHECK(rates.of(kSlow, 1) == doctest::Approx(0.05 * std::pow(1.025, 60)).epsilon(0.02));
  for (int k = 0; k < 200; ++k) rates.hear(100);
  CHECK(rates.of(kSlow, 1) == doctest::Approx(1).epsilon(0.01));
  rates.hear(0);
  CHECK(rates.of(kSlow, 1) == doctest::Approx(0.8).epsilon(0.02));
  REQUIRE(rates.streams.set(1, kSlow, 50'000, 0));  // slowed too
  CHECK(rates.of(kSlow, 1) == doctest::Approx(1.6).epsilon(0.02));
}

TEST_CASE("however full a radio, followers get the state twice a second, or less if requested") {
  Rates rates;
  for (int k = 0; k < 40; ++k) rates.hear(0);
  CHECK(rates.of(link::SysStatus::kId, 1) == doctest::Approx(0.005).epsilon(0.02));
  for (const std::uint16_t id : {link::Attitude::kId, link::LocalPositionNed::kId}) {
    CHECK(rates.of(id, 1) == doctest::Approx(0.2).epsilon(0.02));
    CHECK(rates.of(id, 0) == doctest::Approx(1).epsilon(0.02));
    REQUIRE(rates.streams.set(1, id, 20'000, 0));
    CHECK(rates.of(id, 1) == doctest::Approx(0.25).epsilon(0.02));
    REQUIRE(rates.streams.set(1, id, 2'000'000, 0));
    CHECK(rates.of(id, 1) == doctest::Approx(0.05).epsilon(0.02));
    REQUIRE(rates.streams.set(1, id, -1, 0));
    CHECK(rates.of(id, 1) == 0);
    REQUIRE(rates.streams.set(1, id, 0, 0));
    CHECK(rates.of(id, 1) == doctest::Approx(0.2).epsilon(0.02));
  }
}

TEST_CASE("a radio that is silent for more than five seconds no longer limits its link") {
  Rates rates;
  for (int k = 0; k < 40; ++k) rates.hear(0);
  rates.hear(40, 2);  // neither full nor empty
  rates.streams.forget_silent_radios(rates.now_us + 5 * kSecond_us);
  CHECK(rates.of(link::SysStatus::kId, 1) == doctest::Approx(0.005).epsilon(0.02));
  rates.hear(40);  // as full as before
  const std::int64_t heard_us = rates.now_us;
  rates.streams.forget_silent_radios(heard_us + 5 * kSecond_us);
  rates.streams.radio_has_room(1, 101, heard_us + 4 * kSecond_us);  // no percentage: not heard
  CHECK(rates.of(link::SysStatus::kId, 1) == doctest::Approx(0.005).epsilon(0.02));
  rates.streams.forget_silent_radios(heard_us + 5 * kSecond_us + 1);
  CHECK(rates.of(link::SysStatus::kId, 1) == doctest::Approx(0.1).epsilon(0.02));
  CHECK(rates.of(link::Attitude::kId, 1) == doctest::Approx(1).epsilon(0.02));
  rates.hear(0);
  CHECK(rates.of(link::SysStatus::kId, 1) == doctest::Approx(0.08).epsilon(0.02));
  CHECK(rates.of(link::SysStatus::kId, 2) == doctest::Approx(0.1).epsilon(0.02));
}

TEST_CASE("a link is idle while only the state's stream is due, whatever changed before") {
  constexpr std::uint32_t kSeed = 4;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  RoomyStreams streams(Parameters{}, false, kTick_us);
  int quiet = 0, busy = 0;
  for (std::int64_t now_us = 0; now_us < 300 * kSecond_us; now_us += kTick_us) {
    const std::size_t link = random() % 2, stream = random() % kStreams.size();
    switch (random() % 200) {
      case 0:
        streams.set(link, kStreams[stream].id, static_cast<std::int64_t>(random() % 3'000'000), 0);
        break;
      case 1:
        streams.make_due(kStreams[stream].id);
        break;
      case 2:
        streams.radio_has_room(link, static_cast<std::uint8_t>(random() % 101), now_us);
        break;
      default:
        break;
    }
    streams.forget_silent_radios(now_us);
    bool waits = false;
    for (std::size_t i = 0; i < kStreams.size(); ++i) {
      if (!is_rest(kStreams[i].pace)) continue;
      waits = waits || streams.schedule(i, link).is_due(now_us);
    }
    REQUIRE(streams.any_rest_due(link, now_us) == waits);
    ++(waits ? busy : quiet);
    for (std::size_t i = 0; i < kStreams.size(); ++i) streams.schedule(i, link).take_if_due(now_us);
  }
  CHECK(quiet > 1000);
  CHECK(busy > 1000);
}

}  // namespace
}  // namespace flotilla::app
