// SPDX-License-Identifier: MIT
#include "app/operator/telemetry/telemetry.hpp"

#include <algorithm>
#include <string_view>

#include "app/operator/services/metadata.hpp"
#include "app/operator/telemetry/streams.hpp"
#include "app/operator/telemetry/text.hpp"
#include "app/parameters.hpp"
#include "app/version.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;

constexpr std::uint64_t kCapabilities = mav::kCapabilityMavlink2 | mav::kCapabilityCommandInt |
                                        mav::kCapabilityMissionInt | mav::kCapabilityParamBytewise |
                                        mav::kCapabilityFtp | mav::kCapabilityMissionFence |
                                        mav::kCapabilityMissionRally;

struct Mode {
  std::uint8_t number;
  std::uint32_t properties;
  std::string_view name;
};
// Clients call Rover's mode 6 FOLLOW; the law calls it FORMATION.
constexpr std::array<Mode, 7> kModes{{{mode::kManual, 0, "MANUAL"},
                                      {mode::kHold, 0, "HOLD"},
                                      {mode::kLoiter, mav::kModePropertyAuto, "LOITER"},
                                      {mode::kFormation, mav::kModePropertyAuto, "FOLLOW"},
                                      {mode::kAuto, mav::kModePropertyAuto, "AUTO"},
                                      {mode::kReturn, mav::kModePropertyAuto, "RTL"},
                                      {mode::kGuided, mav::kModePropertyAuto, "GUIDED"}}};

/// MAV_STANDARD_MODE; 0: none.
std::uint8_t standard_mode_of(std::uint8_t mode) {
  if (mode == app::mode::kAuto) return mav::kStandardModeMission;
  return mode == app::mode::kReturn ? mav::kStandardModeSafeRecovery : std::uint8_t{0};
}

std::uint32_t boot_ms(const Report& r) { return convert::boot_ms(r.now_us); }

link::SysStatus sys_status(const Report& r) {
  constexpr std::uint32_t kSensors = mav::kSensorGyro | mav::kSensorAccel | mav::kSensorMag |
                                     mav::kSensorGps | mav::kSensorAhrs |
                                     mav::kSensorPositionControl;
  constexpr std::uint32_t kMotors = mav::kSensorMotors | mav::kSensorPropulsion;
  const auto met = [&r](core::Conditions all) { return (r.conditions & all) == all; };
  const auto battery = convert::battery_of(r.escs[0].status, r.escs[1].status);
  const bool measured = battery.voltages[0] != UINT16_MAX;
  std::uint32_t present = kSensors | kMotors | mav::kSensorPrearm;
  if (r.fenced) present |= mav::kSensorGeofence;
  if (measured || r.battery_limited) present |= mav::kSensorBattery;
  std::uint32_t health = 0;
  if (met(core::kOwn)) health |= kSensors;
  if (met(core::kPropulsion)) health |= kMotors;
  if (met(core::kArming | core::kOwn | core::kOwnGood | core::kLimits))
    health |= mav::kSensorPrearm;
  if (!r.fenced || met(core::kInsideFence)) health |= mav::kSensorGeofence;
  if (measured && met(core::kBatteryGood)) health |= mav::kSensorBattery;
  const std::uint32_t off = r.fence_is_off ? mav::kSensorGeofence : 0;
  return {present, present & ~off, health, 0, battery.voltages[0], battery.current_battery, -1};
}

link::AutopilotVersion autopilot_version(const Report& r) {
  link::AutopilotVersion version{};
  version.capabilities = kCapabilities;
  version.uid = kUidFamily | r.self.system;
  version.flight_sw_version = std::uint32_t{kVersionMajor} << 24U | std::uint32_t{kVersionMinor}
                                                                        << 16U;
  const std::string_view revision = source_revision();
  std::copy_n(revision.begin(), std::min(revision.size(), version.flight_custom_version.size()),
              version.flight_custom_version.begin());
  return version;
}

link::ComponentInformationBasic component_information(const Report& r) {
  link::ComponentInformationBasic basic{};
  basic.time_boot_ms = boot_ms(r);
  basic.capabilities = kCapabilities;
  put_text(basic.vendor_name, "Flotilla");
  put_text(basic.model_name, "twin-propeller boat");
  put_text(basic.software_version, source_revision());
  return basic;
}

link::ComponentMetadata component_metadata(const Report& r) {
  link::ComponentMetadata metadata{boot_ms(r), general_crc(), {}};
  put_text(metadata.uri, kGeneralUri);
  return metadata;
}

std::optional<link::Message> available_mode(std::uint32_t turn) {
  if (turn >= kModes.size()) return std::nullopt;
  const Mode& mode = kModes[turn];
  link::AvailableModes out{static_cast<std::uint8_t>(kModes.size()),
                           static_cast<std::uint8_t>(turn + 1),
                           standard_mode_of(mode.number),
                           mode.number,
                           mode.properties,
                           {}};
  put_text(out.mode_name, mode.name);
  return out;
}

/// MAVLink groups ESCs by four; both propellers may share a group.
std::optional<std::uint8_t> esc_group(std::uint32_t turn, const Report& r) {
  const auto group_of = [](std::uint8_t index) { return static_cast<std::uint8_t>(index / 4 * 4); };
  const std::uint8_t port = group_of(r.escs[0].index), stbd = group_of(r.escs[1].index);
  if (turn == 0) return port;
  if (turn == 1 && stbd != port) return stbd;
  return std::nullopt;
}

std::optional<link::Message> esc_status(std::uint32_t turn, const Report& r) {
  const auto group = esc_group(turn, r);
  if (!group) return std::nullopt;
  link::MavEscStatus out{*group, static_cast<std::uint64_t>(r.now_us), {}, {}, {}};
  for (const EscReport& esc : r.escs) {
    if (esc.index / 4 * 4 != *group || !esc.status) continue;
    const std::size_t at = esc.index % 4U;
    out.rpm[at] = esc.status->rpm;
    out.voltage[at] = esc.status->voltage;
    out.current[at] = esc.status->current;
  }
  return out;
}

std::optional<link::Message> esc_info(std::uint32_t turn, const Report& r) {
  const auto group = esc_group(turn, r);
  if (!group) return std::nullopt;
  constexpr std::uint8_t kConnectionCan = 5;
  link::MavEscInfo out{};
  out.index = *group;
  out.time_usec = static_cast<std::uint64_t>(r.now_us);
  // Clients ignore indices from count on.
  out.count = static_cast<std::uint8_t>(std::max(r.escs[0].index, r.escs[1].index) + 1);
  out.connection_type = kConnectionCan;
  out.temperature.fill(INT16_MAX);
  for (const EscReport& esc : r.escs) {
    if (esc.index / 4 * 4 != *group || !esc.status) continue;
    const std::size_t at = esc.index % 4U;
    out.info = static_cast<std::uint8_t>(out.info | 1U << at);
    out.error_count[at] = esc.status->error_count;
    out.temperature[at] = convert::centidegrees_of_kelvin(esc.status->temperature);
  }
  return out;
}

using F = FormationReport;
using E = Estimates;
using R = Report;
using Number = std::optional<double>;

template <auto of>
Number number(const Report& r) {
  return of(r);
}
template <auto of>
Number formation(const Report& r) {
  return r.formation ? Number(of(*r.formation)) : std::nullopt;
}
template <auto of>
Number estimate(const Report& r) {
  return r.estimates ? Number(of(*r.estimates)) : std::nullopt;
}
Number in_slot(const Report& r) {
  return r.formation && r.formation->in_slot ? Number(*r.formation->in_slot ? 1 : 0) : std::nullopt;
}
constexpr unsigned kCond = 24;  // bits that a float counts exactly
core::Conditions met(const Report& r) { return r.conditions & core::kAllConditions; }

struct NamedValue {
  const char* name;
  Number (*of)(const Report&);
};
/// Errors, desired values, missing wrench, ages, conditions, thrusts.
constexpr std::array<NamedValue, 26> kValues{{
    {"E_X", formation<[](const F& f) { return f.error.x; }>},
    {"E_Y", formation<[](const F& f) { return f.error.y; }>},
    {"E_PSI", formation<[](const F& f) { return f.error.psi; }>},
    {"IN_SLOT", in_slot},
    {"U_STAR", formation<[](const F& f) { return f.nu_star.u; }>},
    {"R_STAR", formation<[](const F& f) { return f.nu_star.r; }>},
    {"LACK_X", formation<[](const F& f) { return f.missing.X; }>},
    {"LACK_N", formation<[](const F& f) { return f.missing.N; }>},
    {"NAV_AGE", number<[](const R& r) { return r.own_age_s; }>},
    {"LEAD_AGE", number<[](const R& r) { return r.leader_age_s; }>},
    {"LEAD_UNC", number<[](const R& r) { return r.leader_uncertainty_m; }>},
    {"UNK_X", estimate<[](const E& e) { return e.unknown.X; }>},
    {"UNK_N", estimate<[](const E& e) { return e.unknown.N; }>},
    {"CUR_N", estimate<[](const E& e) { return e.current_n.x; }>},
    {"CUR_E", estimate<[](const E& e) { return e.current_n.y; }>},
    {"LRN_BAL", number<[](const R& r) { return r.balance; }>},
    {"LRN_DRAG", number<[](const R& r) { return r.drag; }>},
    {"LRN_YAWD", number<[](const R& r) { return r.yaw_damping; }>},
    {"LEADER", number<[](const R& r) { return double(r.leader); }>},
    {"COND", number<[](const R& r) { return double(met(r) % (1U << kCond)); }>},
    {"COND2", number<[](const R& r) { return double(met(r) >> kCond); }>},
    {"T_PORT", number<[](const R& r) { return r.thrust.port; }>},
    {"T_STBD", number<[](const R& r) { return r.thrust.stbd; }>},
    {"T_MAX", number<[](const R& r) { return r.most_N; }>},
    {"T_MIN", number<[](const R& r) { return r.least_N; }>},
    {"OVERRUNS", number<[](const R& r) { return double(r.overruns); }>},
}};

/// One message each.
std::optional<link::Message> named_value(std::uint32_t turn, const Report& r) {
  for (const NamedValue& v : kValues) {
    const Number value = v.of(r);
    if (value && turn-- == 0) return value_of(v.name, static_cast<float>(*value), boot_ms(r));
  }
  return std::nullopt;
}

/// Messages that need the boat's state.
std::optional<link::Message> compose_own(std::uint16_t id, const OwnReport& own, const Report& r) {
  switch (id) {
    case link::Attitude::kId:
      return convert::attitude_of(own.state, own.time_boot_ms);
    case link::LocalPositionNed::kId:
      if (!own.adrift) return convert::local_position_of(own.state, own.time_boot_ms);
      break;
    case link::Odometry::kId:
      return convert::odometry_of(own.state, own.time_boot_ms);
    case link::NavControllerOutput::kId:
      if (r.formation) return convert::nav_controller_output_of(own.state, r.formation->error);
      break;
    case link::PositionTargetLocalNed::kId:
      if (r.formation) return convert::slot_of(own.state, r.formation->error, own.time_boot_ms);
      break;
    default:
      break;
  }
  if (!own.located) return std::nullopt;
  switch (id) {
    case link::GpsGlobalOrigin::kId: {
      link::GpsGlobalOrigin origin = own.state.origin;
      origin.time_usec = static_cast<std::uint64_t>(r.now_us);
      return origin;
    }
    case link::GlobalPositionInt::kId:
      return convert::global_position_of(own.state, own.time_boot_ms);
    case link::FollowTarget::kId:
      return convert::follow_target_of(own.state, own.time_boot_ms);
    case link::VfrHud::kId:
      return convert::vfr_hud_of(own.state, r.thrust, r.most_N);
    default:
      return std::nullopt;
  }
}

}  // namespace

bool can_compose(std::uint16_t id) {
  constexpr std::array kOnceOnly{link::AutopilotVersion::kId,
                                 link::ProtocolVersion::kId,
                                 link::ComponentInformationBasic::kId,
                                 link::ComponentMetadata::kId,
                                 link::AvailableModes::kId,
                                 link::Odometry::kId};
  if (id == link::FormationFuture::kId) return false;  // sent only as news
  return std::ranges::find(kOnceOnly, id) != kOnceOnly.end() ||
         std::ranges::any_of(kStreams, [&](const StreamInfo& info) { return info.id == id; });
}

std::optional<link::Message> compose(std::uint16_t id, std::uint32_t turn, const Report& r) {
  switch (id) {  // ids with several messages
    case link::AvailableModes::kId:
      return available_mode(turn);
    case link::MavEscStatus::kId:
      return esc_status(turn, r);
    case link::MavEscInfo::kId:
      return esc_info(turn, r);
    case link::NamedValueFloat::kId:
      return named_value(turn, r);
    default:
      break;
  }
  if (turn > 0) return std::nullopt;
  switch (id) {
    case link::SysStatus::kId:
      return sys_status(r);
    case link::SystemTime::kId:
      return link::SystemTime{static_cast<std::uint64_t>(r.unix_us), boot_ms(r)};
    case link::HomePosition::kId:
      if (!r.home) return std::nullopt;
      return link::HomePosition{r.home->latitude,
                                r.home->longitude,
                                r.home->altitude_mm,
                                0,
                                0,
                                0,
                                {1, 0, 0, 0},
                                static_cast<std::uint64_t>(r.now_us)};
    case link::AutopilotVersion::kId:
      return autopilot_version(r);
    case link::ProtocolVersion::kId:
      return link::ProtocolVersion{200, 100, 200};
    case link::ComponentInformationBasic::kId:
      return component_information(r);
    case link::ComponentMetadata::kId:
      return component_metadata(r);
    case link::CurrentMode::kId:
      return link::CurrentMode{standard_mode_of(r.mode), r.mode, r.intended_mode};
    case link::MissionCurrent::kId:
      if (!r.plan) return std::nullopt;
      return link::MissionCurrent{r.plan->item, r.plan->count,    r.plan->state,   0,
                                  r.plan->id,   r.plan->fence_id, r.plan->rally_id};
    case link::FenceStatus::kId:
      if (!r.fence) return std::nullopt;
      return link::FenceStatus{r.fence->breached, r.fence->breaches,
                               r.fence->breached ? mav::kBreachBoundary : mav::kBreachNone,
                               r.fence->last_ms};
    case link::GpsRawInt::kId:
      if (!r.gps) return std::nullopt;
      return *r.gps;
    case link::FormationReference::kId:
      if (!r.reference) return std::nullopt;
      return *r.reference;
    case link::BatteryStatus::kId:
      return convert::battery_of(r.escs[0].status, r.escs[1].status);
    case link::ExtendedSysState::kId:
      return link::ExtendedSysState{0, 0};
    default:
      return r.own ? compose_own(id, *r.own, r) : std::nullopt;
  }
}

}  // namespace flotilla::app
