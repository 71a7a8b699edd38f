// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <cstring>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "app/every_id.hpp"
#include "app/operator/telemetry/streams.hpp"
#include "app/operator/telemetry/telemetry.hpp"
#include "link/any_message.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;

constexpr link::GpsGlobalOrigin kOrigin{410'000'000, 20'000'000, 0, 0};

/// A report in which every value is known.
Report full() {
  Report r;
  r.now_us = 12'345'678;
  r.unix_us = 1'700'000'000'000'000;
  r.conditions = core::kAllConditions;
  r.mode = 6;
  r.intended_mode = 6;
  r.own = OwnReport{
      12'345, convert::own_state_of<double>({1, 2, kOrigin}, {{0.5, 0}, 0.3, {1, 0, 0.1}, {}}),
      true};
  r.gps = link::GpsRawInt{};
  r.home = Home{410'000'100, 20'000'100, 5000};
  r.formation = FormationReport{true, {1, 2, 0.1}, {1, 0, 0.2}, {0.5, 0.25}};
  r.reference = link::FormationReference{};
  r.reference->path.fill(1);
  r.reference->offset_b.fill(-1);
  r.plan = PlanReport{1, 5, mav::kMissionActive, 12345};
  r.fence = FenceReport{};
  r.own_age_s = 0.1;
  r.leader_age_s = 0.2;
  r.leader_uncertainty_m = 0.3;
  r.estimates = Estimates{{-1.5, 0.75}, {0.1, -0.2}};
  r.thrust = {3.5, -2.5};
  r.most_N = 20;
  r.least_N = -12;
  r.leader = 100;
  r.escs = {EscReport{0, link::EscStatus{}}, EscReport{1, link::EscStatus{}}};
  r.self = {7, 1};
  return r;
}

std::vector<link::Message> all(std::uint16_t id, const Report& r) {
  std::vector<link::Message> out;
  while (auto message = compose(id, static_cast<std::uint32_t>(out.size()), r)) {
    out.push_back(*message);
    REQUIRE(out.size() < 100);
  }
  return out;
}

template <class M>
std::vector<M> all_as(std::uint16_t id, const Report& r) {
  std::vector<M> out;
  for (const link::Message& m : all(id, r)) out.push_back(std::get<M>(m));
  return out;
}

testing::Bytes frame(const link::Message& message) {
  link::MavlinkEncoder encoder({7, 1});
  return testing::frame_of(encoder, message);
}

std::uint32_t id_on_the_wire(const link::Message& message) {
  const testing::Bytes bytes = frame(message);
  REQUIRE(bytes.size() > 10);
  return bytes[7] + 256U * bytes[8] + 65536U * bytes[9];
}

/// A random report: any value may be unknown, with any ESC at any index.
Report any_report(std::mt19937& random) {
  Report r = full();
  const auto often = [&] { return random() % 3 != 0; };
  if (!often()) r.own.reset();
  if (r.own) r.own->located = often();
  if (!often()) r.home.reset();
  if (!often()) r.formation.reset();
  if (!often()) r.reference.reset();
  if (!often()) r.plan.reset();
  if (!often()) r.fence.reset();
  if (!often()) r.own_age_s.reset();
  if (!often()) r.leader_age_s.reset();
  if (!often()) r.leader_uncertainty_m.reset();
  if (!often()) r.estimates.reset();
  for (EscReport& esc : r.escs) {
    esc.index = static_cast<std::uint8_t>(random() % 20);
    if (!often()) esc.status.reset();
  }
  r.conditions = static_cast<core::Conditions>(random() & core::kAllConditions);
  return r;
}

TEST_CASE("every stream and requestable message is sent under its number when all is known") {
  for (const std::uint16_t id : testing::kEveryId) {
    CAPTURE(id);
    const auto messages = all(id, full());
    // The vehicle composes these two itself.
    const bool elsewhere = id == link::Heartbeat::kId || id == link::MessageInterval::kId;
    CHECK(messages.empty() == elsewhere);
    for (const link::Message& m : messages) CHECK(id_on_the_wire(m) == id);
  }
  for (const StreamInfo& info : kStreams) {
    CAPTURE(info.id);
    CHECK(all(info.id, full()).empty() == (info.id == link::FormationFuture::kId));
  }
}

TEST_CASE("an unknown id gives no message, and neither does a turn after an id's last message") {
  constexpr std::uint32_t kSeed = 23;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  std::vector<bool> known(UINT16_MAX + 1U);
  for (const std::uint16_t id : testing::kEveryId) known[id] = true;
  for (unsigned id = 0; id <= UINT16_MAX; ++id) {
    if (!known[id]) REQUIRE_FALSE(compose(static_cast<std::uint16_t>(id), 0, full()));
  }
  for (int k = 0; k < 300; ++k) {
    const Report r = any_report(random);
    for (const std::uint16_t id : testing::kEveryId) {
      const auto count = static_cast<std::uint32_t>(all(id, r).size());
      CAPTURE(id);
      for (std::uint32_t turn = count; turn < count + 30; ++turn)
        REQUIRE_FALSE(compose(id, turn, r));
      for (const std::uint32_t turn : {255U, 256U, 65536U, UINT32_MAX - 1, UINT32_MAX}) {
        REQUIRE_FALSE(compose(id, turn, r));
      }
    }
  }
}

TEST_CASE("no stream is longer on the wire than its table says, wherever the ESCs are") {
  for (const StreamInfo& info : kStreams) {
    for (const std::uint8_t stbd : std::initializer_list<std::uint8_t>{1, 3, 4, 19}) {
      Report r = full();
      r.escs[1].index = stbd;
      std::size_t bytes = 0;
      for (const link::Message& m : all(info.id, r)) bytes += frame(m).size();
      CAPTURE(info.id);
      CAPTURE(stbd);
      CHECK(bytes <= info.bytes);
    }
  }
}

TEST_CASE("messages of the own state need it, global ones need an origin; else they are not sent") {
  Report blind = full(), lost = full();
  blind.own.reset();
  lost.own->located = false;
  for (const std::uint16_t id :
       {link::Attitude::kId, link::LocalPositionNed::kId, link::Odometry::kId,
        link::NavControllerOutput::kId, link::PositionTargetLocalNed::kId}) {
    CHECK(all(id, blind).empty());
    CHECK(all(id, lost).size() == 1);
  }
  for (const std::uint16_t id :
       {link::GlobalPositionInt::kId, link::FollowTarget::kId, link::GpsGlobalOrigin::kId}) {
    CHECK(all(id, blind).empty());
    CHECK(all(id, lost).empty());
  }
  Report alone = full();
  alone.formation.reset();
  CHECK(all(link::NavControllerOutput::kId, alone).empty());
  CHECK(all(link::PositionTargetLocalNed::kId, alone).empty());
  Report new_here = full();
  new_here.home.reset();
  CHECK(all(link::HomePosition::kId, new_here).empty());
}

TEST_CASE("positions relative to an earlier origin are not sent, as no receiver could place them") {
  Report r = full();
  r.own->located = false;
  r.own->adrift = true;
  CHECK(all(link::LocalPositionNed::kId, r).empty());
  CHECK(all(link::GlobalPositionInt::kId, r).empty());
  CHECK(all(link::Attitude::kId, r).size() == 1);
}

TEST_CASE("whether an id can be composed does not depend on the data that is known") {
  for (unsigned id = 0; id <= UINT16_MAX; ++id) {
    const bool is_made = compose(static_cast<std::uint16_t>(id), 0, full()).has_value();
    CAPTURE(id);
    REQUIRE(can_compose(static_cast<std::uint16_t>(id)) == is_made);
  }
}

TEST_CASE("modes are listed from 1 on, each once, as Rover numbers and names them") {
  const auto modes = all_as<link::AvailableModes>(link::AvailableModes::kId, full());
  REQUIRE(modes.size() == 7);
  const std::array<std::uint32_t, 7> numbers{0, 4, 5, 6, 10, 11, 15};
  const std::array<std::string, 7> names{"MANUAL", "HOLD", "LOITER", "FOLLOW",
                                         "AUTO",   "RTL",  "GUIDED"};
  for (std::size_t i = 0; i < 7; ++i) {
    CHECK(modes[i].number_modes == 7);
    CHECK(modes[i].mode_index == i + 1);
    const int standard = numbers[i] == 10 ? 6 : numbers[i] == 11 ? 5 : 0;  // MISSION, SAFE_RECOVERY
    CHECK(modes[i].standard_mode == standard);
    CHECK(modes[i].custom_mode == numbers[i]);
    CHECK(std::string(modes[i].mode_name.data()) == names[i]);
    CHECK((modes[i].properties & mav::kModePropertyNotUserSelectable) == 0);
    CHECK(((modes[i].properties & mav::kModePropertyAuto) != 0) == (numbers[i] > 4));
  }
}

TEST_CASE("both propellers' ESCs are where their indices say, in one group of four or in two") {
  for (std::uint8_t port = 0; port < 20; ++port) {
    for (std::uint8_t stbd = 0; stbd < 20; ++stbd) {
      if (port == stbd) continue;
      Report r = full();
      link::EscStatus a, b;
      a.rpm = 1000, a.voltage = 12, a.current = 3, a.error_count = 5, a.temperature = 300;
      b.rpm = -2000, b.voltage = 11, b.current = 4, b.error_count = 6, b.temperature = 310;
      r.escs = {EscReport{port, a}, EscReport{stbd, b}};
      const bool together = port / 4 == stbd / 4;
      const auto status = all_as<link::MavEscStatus>(link::MavEscStatus::kId, r);
      const auto info = all_as<link::MavEscInfo>(link::MavEscInfo::kId, r);
      REQUIRE(status.size() == (together ? 1 : 2));
      REQUIRE(info.size() == status.size());
      CHECK(status[0].index == port / 4 * 4);
      CHECK(info[0].index == port / 4 * 4);
      const auto& port_status = status.front();
      const auto& stbd_status = status.back();
      CHECK(stbd_status.index == stbd / 4 * 4);
      CHECK(port_status.rpm[port % 4U] == 1000);
      CHECK(stbd_status.rpm[stbd % 4U] == -2000);
      CHECK(stbd_status.voltage[stbd % 4U] == 11);
      CHECK(port_status.current[port % 4U] == 3);
      CHECK(info.front().error_count[port % 4U] == 5);
      CHECK(info.back().temperature[stbd % 4U] == 3685);
      unsigned online = 0;
      for (const auto& group : info) {
        for (unsigned i = 0; i < 4; ++i) {
          const bool on = (group.info >> i & 1U) != 0;
          online += on ? 1 : 0;
          const auto esc = group.index + i;
          CHECK(on == (esc == port || esc == stbd));
          if (!on) CHECK(group.temperature[i] == INT16_MAX);
        }
        CHECK(group.count == std::max(port, stbd) + 1);
      }
      CHECK(online == 2);
    }
  }
}

TEST_CASE("a silent ESC is offline and has no values") {
  Report r = full();
  r.escs[1].status.reset();
  const auto info = all_as<link::MavEscInfo>(link::MavEscInfo::kId, r);
  REQUIRE(info.size() == 1);
  CHECK(info[0].info == 1);
  CHECK(info[0].temperature[1] == INT16_MAX);
  r.escs[0].status.reset();
  CHECK(all_as<link::MavEscInfo>(link::MavEscInfo::kId, r)[0].info == 0);
  CHECK(all_as<link::SysStatus>(link::SysStatus::kId, r)[0].voltage_battery == UINT16_MAX);
}

TEST_CASE("named values are those that are known, each once, all by names of up to ten letters") {
  const auto names = [](const Report& r) {
    std::string out;
    for (const auto& v : all_as<link::NamedValueFloat>(link::NamedValueFloat::kId, r)) {
      CHECK(v.time_boot_ms == 12'345);
      out += std::string(v.name.data(), ::strnlen(v.name.data(), v.name.size())) + " ";
    }
    return out;
  };
  Report r = full();
  CHECK(names(r) ==
        "E_X E_Y E_PSI IN_SLOT U_STAR R_STAR LACK_X LACK_N NAV_AGE LEAD_AGE LEAD_UNC UNK_X UNK_N "
        "CUR_N CUR_E "
        "LEADER COND COND2 T_PORT T_STBD T_MAX T_MIN OVERRUNS ");
  const auto values = all_as<link::NamedValueFloat>(link::NamedValueFloat::kId, r);
  constexpr float kSecond = static_cast<float>(core::kAllConditions >> 24U);
  const std::array expected{1.0F,        2.0F,    0.1F, 1.0F,  1.0F,  0.2F,   0.5F,  0.25F,
                            0.1F,        0.2F,    0.3F, -1.5F, 0.75F, 0.1F,   -0.2F, 100.0F,
                            16777215.0F, kSecond, 3.5F, -2.5F, 20.0F, -12.0F, 0.0F};
  for (std::size_t i = 0; i < expected.size(); ++i) CHECK(values[i].value == expected[i]);
  r.formation.reset();
  const std::string always = "LEADER COND COND2 T_PORT T_STBD T_MAX T_MIN OVERRUNS ";
  CHECK(names(r) == "NAV_AGE LEAD_AGE LEAD_UNC UNK_X UNK_N CUR_N CUR_E " + always);
  r.own_age_s.reset();
  r.leader_age_s.reset();
  r.leader_uncertainty_m.reset();
  r.estimates.reset();
  CHECK(names(r) == always);
  r.balance = 0.06F;
  r.yaw_damping = 0.5F;
  CHECK(names(r) == "LRN_BAL LRN_YAWD " + always);
}

TEST_CASE("SYS_STATUS reports whether sensors, motors and arming are well, whatever is wrong") {
  constexpr std::uint32_t kSensors = 1 | 2 | 4 | 32 | 0x4000 | 0x200000;
  constexpr std::uint32_t kMotors = 0x8000 | 0x40000000;
  for (unsigned one = 0; one < core::kConditionCount; ++one) {
    for (unsigned other = 0; other < core::kConditionCount; ++other) {
      Report r = full();
      r.conditions =
          core::kAllConditions & ~(core::Conditions{1} << one | core::Conditions{1} << other);
      const auto has = [&](core::Conditions all) { return (r.conditions & all) == all; };
      const auto s = all_as<link::SysStatus>(link::SysStatus::kId, r)[0];
      REQUIRE((s.sensors_health & kSensors) == (has(core::kOwn) ? kSensors : 0));
      REQUIRE((s.sensors_health & kMotors) == (has(core::kPropulsion) ? kMotors : 0));
      constexpr core::Conditions kReady =
          core::kArming | core::kOwn | core::kOwnGood | core::kLimits;
      REQUIRE(((s.sensors_health & mav::kSensorPrearm) != 0) == has(kReady));
      REQUIRE((s.sensors_present & (kSensors | kMotors)) == (kSensors | kMotors));
      REQUIRE((s.sensors_present & s.sensors_enabled) == s.sensors_enabled);
      REQUIRE(s.battery_remaining == -1);
    }
  }
}

TEST_CASE("SYS_STATUS reports the health of a fence and a battery where there are any") {
  const auto status_of = [](const Report& r, std::uint32_t bit) {
    const auto s = all_as<link::SysStatus>(link::SysStatus::kId, r)[0];
    CHECK((s.sensors_enabled & bit) == (s.sensors_present & bit));
    return std::pair((s.sensors_present & bit) != 0, (s.sensors_health & bit) != 0);
  };
  using Status = std::pair<bool, bool>;
  Report r = full();
  r.conditions = core::kAllConditions;
  CHECK(status_of(r, mav::kSensorGeofence) == Status{false, true});  // no fence can be broken
  CHECK(status_of(r, mav::kSensorBattery) == Status{true, true});
  r.fenced = r.battery_limited = true;
  CHECK(status_of(r, mav::kSensorGeofence) == Status{true, true});
  CHECK(status_of(r, mav::kSensorBattery) == Status{true, true});
  r.conditions &= ~(core::kInsideFence | core::kBatteryGood);
  CHECK(status_of(r, mav::kSensorGeofence) == Status{true, false});
  CHECK(status_of(r, mav::kSensorBattery) == Status{true, false});
  r.escs = {};
  CHECK(status_of(r, mav::kSensorBattery) == Status{true, false});
  r.battery_limited = false;
  CHECK(status_of(r, mav::kSensorBattery) == Status{false, false});
}

TEST_CASE("the boat reports its capabilities, its vendor and the location of its description") {
  const auto version = all_as<link::AutopilotVersion>(link::AutopilotVersion::kId, full())[0];
  CHECK(version.capabilities == (8192 | 4 | 8 | 16 | 32 | 16384 | 32768));
  CHECK(version.uid != 0);
  Report sister = full();
  sister.self.system = 8;
  CHECK(all_as<link::AutopilotVersion>(link::AutopilotVersion::kId, sister)[0].uid != version.uid);
  const auto metadata = all_as<link::ComponentMetadata>(link::ComponentMetadata::kId, full())[0];
  CHECK(std::string(metadata.uri.data()) == "mftp:///general.json");
  CHECK(metadata.file_crc != 0);
  const auto protocol = all_as<link::ProtocolVersion>(link::ProtocolVersion::kId, full())[0];
  CHECK(protocol.version == 200);
  const auto mode = all_as<link::CurrentMode>(link::CurrentMode::kId, full())[0];
  CHECK(mode.custom_mode == 6);
  const auto time = all_as<link::SystemTime>(link::SystemTime::kId, full())[0];
  CHECK(time.time_unix_usec == 1'700'000'000'000'000);
  CHECK(time.time_boot_ms == 12'345);
  const auto origin = all_as<link::GpsGlobalOrigin>(link::GpsGlobalOrigin::kId, full())[0];
  CHECK(origin.latitude == kOrigin.latitude);
  const auto home = all_as<link::HomePosition>(link::HomePosition::kId, full())[0];
  CHECK(home.latitude == 410'000'100);
}

}  // namespace
}  // namespace flotilla::app
