// SPDX-License-Identifier: MIT
#include "app/parameters/configuration.hpp"

#include <algorithm>
#include <array>

#include "app/convert/times.hpp"
#include "app/parameters/derived.hpp"

namespace flotilla::app {
namespace {

template <class T>
T whole(float parameter) {
  return static_cast<T>(parameter);
}

template <class T>
std::optional<T> unless_zero(T value) {
  return value > T{} ? std::optional(value) : std::nullopt;
}

std::optional<float> unless_negative(float value) {
  return value < 0 ? std::nullopt : std::optional(value);
}

core::Reaction reaction_of(float action) {
  using enum core::Reaction;
  constexpr std::array kActions{kHold, kCoast, kManual, kLoiter, kReturn};
  return kActions[whole<std::size_t>(action)];
}

core::Reaction stop_of(float action) {
  using enum core::Reaction;
  constexpr std::array kStops{kHold, kLoiter, kReturn};
  return kStops[whole<std::size_t>(action)];
}

}  // namespace

Configuration configuration_of(const Parameters& p) {
  using convert::microseconds, convert::period_us;
  using Byte = std::uint8_t;
  const std::optional<float> leader_lag_s = unless_negative(p.FORM_LAG_S);
  return {
      .start = {.system = whole<Byte>(p.MAV_SYSID),
                .component = whole<Byte>(p.MAV_COMPID),
                .companion = p.MAV_IDENTITY > 0,
                .ardupilot = p.MAV_AUTOPILOT > 0,
                .can_node = whole<Byte>(p.CAN_NODE),
                .tick_us = period_us(p.CTL_RATE)},
      .formation = {.leader = whole<Byte>(p.FORM_LEADER),
                    .north_m = p.FORM_OFS_N,
                    .east_m = p.FORM_OFS_E,
                    .turns = p.FORM_FRAME > 0,
                    .reach_m = unless_zero(p.FORM_DIST_MAX),
                    .follows_root = p.LAW_REF > 0,
                    .leader_lag_us =
                        leader_lag_s ? std::optional(microseconds(*leader_lag_s)) : std::nullopt,
                    .max_depth = unless_zero(whole<std::size_t>(p.FORM_DEPTH)),
                    .beam_m = 2 * p.THR_ARM,
                    .separation_m = separation_m(p),
                    .judges_station = p.FS_SLOT_M > 0,
                    .wait_us = microseconds(p.WP_WAIT_S),
                    .returns_alone = p.RTL_ALONE > 0},
      .plan = {.speed_mps = p.WP_SPEED,
               .radius_m = p.WP_RADIUS,
               .fastest_mps = p.LAW_U_MAX,
               .margin_m = p.BOAT_LEN + p.WP_WIDTH,
               .room_m = std::max(15 * p.BOAT_LEN, 60.0F),
               .fastest_radps = 2 * p.LAW_R_MAX},
      // Brakes with half of the astern thrust, within the values that Q16.16 can divide by.
      .stopping = {.reaction_s = 1,
                   .brake_mps2 = std::clamp(p.THR_REV_MAX / p.VES_M11, 0.02F, 0.5F),
                   .drag_s = std::min(p.VES_M11 / p.VES_D11, 60.0F)},
      .navigation = {.lag_s = unless_negative(p.NAV_LAG_S),
                     .component = whole<Byte>(p.NAV_COMPID),
                     .link = p.NAV_LINK < 0 ? std::nullopt : std::optional(whole<Byte>(p.NAV_LINK)),
                     .quality = {.fix = whole<Byte>(p.NAV_FIX),
                                 .hdop = p.NAV_HDOP,
                                 .accuracy_m = p.NAV_ACC_M,
                                 .ratio = p.NAV_VAR},
                     .own_limit_us = microseconds(p.FS_NAV_S),
                     .leader_limit_us = microseconds(p.FS_LEADER_S)},
      .propulsion = {.port_esc = whole<Byte>(p.ESC_PORT),
                     .stbd_esc = whole<Byte>(p.ESC_STBD),
                     .port_reversed = p.THR_PORT_DIR < 0,
                     .stbd_reversed = p.THR_STBD_DIR < 0,
                     .ahead_N = p.THR_FWD_MAX,
                     .astern_N = p.THR_REV_MAX,
                     .dead_N = p.THR_DEAD,
                     .esc_limit_us = microseconds(p.FS_ESC_S)},
      .failsafes = {.choices = {.leader = reaction_of(p.FS_LEADER_ACT),
                                .gcs = reaction_of(p.FS_GCS_ACT),
                                .battery = stop_of(p.FS_BATT_ACT),
                                .fence = stop_of(p.FS_FENCE_ACT),
                                .coast_end = stop_of(p.FS_COAST_ACT)},
                    .coast_us = microseconds(p.FS_COAST_S),
                    .battery_V = unless_zero(p.FS_BATT_V),
                    .fence_m = unless_zero(p.FS_FENCE_M)},
      .operators = {.commander = unless_zero(whole<Byte>(p.MAV_GCS_SYSID)),
                    .rc_switch = unless_zero(whole<Byte>(p.RC_MODE_CH)),
                    .gcs_limit_us = unless_zero(microseconds(p.FS_GCS_S)),
                    .state_us = period_us(p.SR_STATE),
                    .slow_us = period_us(p.SR_SLOW)},
      .gains_fit = !gain_fault(p),
  };
}

}  // namespace flotilla::app
