// SPDX-License-Identifier: MIT
#include "snapshot.hpp"

#include <nanobind/stl/optional.h>

#include "app/operator/telemetry/text.hpp"
#include "values.hpp"

namespace nb = nanobind;
using namespace flotilla;

namespace {

nb::dict counters_dict(const link::Counters& c) {
  nb::dict out;
  out["mavlink_received"] = c.mavlink_received;
  out["mavlink_bad_checksum"] = c.mavlink_bad_checksum;
  out["mavlink_skipped_bytes"] = c.mavlink_skipped_bytes;
  out["mavlink_bad_value"] = c.mavlink_bad_value;
  out["mavlink_bad_frame"] = c.mavlink_bad_frame;
  out["mavlink_old_stamp"] = c.mavlink_old_stamp;
  out["mavlink_jump"] = c.mavlink_jump;
  out["mavlink_no_heading"] = c.mavlink_no_heading;
  out["reference_refused"] = c.reference_refused;
  out["mavlink_unknown"] = c.mavlink_unknown;
  out["mavlink_signed"] = c.mavlink_signed;
  out["mavlink_forged"] = c.mavlink_forged;
  out["mavlink_replayed"] = c.mavlink_replayed;
  out["mavlink_future_stamp"] = c.mavlink_future_stamp;
  out["mavlink_streams_full"] = c.mavlink_streams_full;
  out["mavlink_unsigned_refused"] = c.mavlink_unsigned_refused;
  out["mavlink_not_sent"] = c.mavlink_not_sent;
  out["requests_dropped"] = c.requests_dropped;
  out["can_received"] = c.can_received;
  out["can_bad_frame"] = c.can_bad_frame;
  out["can_bad_checksum"] = c.can_bad_checksum;
  out["can_bad_value"] = c.can_bad_value;
  out["can_not_sent"] = c.can_not_sent;
  out["clock_went_back"] = c.clock_went_back;
  return out;
}

}  // namespace

nb::dict snapshot_dict(const app::Snapshot& s) {
  nb::dict conditions;
  for (const auto& [bit, name] : kConditionNames) conditions[name] = (s.conditions & bit) != 0;
  nb::dict limited;
  limited["surge"] = (s.limits & core::kSurgeLimit) != 0;
  limited["yaw"] = (s.limits & core::kYawLimit) != 0;
  limited["slew"] = (s.limits & core::kSlewLimit) != 0;
  limited["speed"] = (s.limits & core::kSpeedLimit) != 0;
  limited["yaw_rate"] = (s.limits & core::kYawRateLimit) != 0;
  limited["yielding"] = s.yielding;
  nb::dict out;
  out["state"] = nb::str(app::name_of(s.state).data(), app::name_of(s.state).size());
  out["conditions"] = conditions;
  out["own_age_s"] = s.own_age_s;
  out["leader_age_s"] = s.leader_age_s;
  out["leader_uncertainty_m"] = s.leader_uncertainty_m;
  out["reference_age_s"] = s.reference_age_s;
  out["unknown"] = pair("X_N", s.estimates.unknown.X, "N_Nm", s.estimates.unknown.N);
  out["current_mps"] = pair("north", s.estimates.current_n.x, "east", s.estimates.current_n.y);
  out["error"] =
      s.error_known ? nb::object(triple("x_m", s.error.x, "y_m", s.error.y, "psi_rad", s.error.psi))
                    : nb::none();
  out["in_slot"] = s.in_slot;
  out["virtual_velocity"] =
      triple("u_mps", s.nu_star.u, "v_mps", s.nu_star.v, "r_radps", s.nu_star.r);
  out["wrench_asked"] = pair("X_N", s.asked.X, "N_Nm", s.asked.N);
  out["wrench_given"] = pair("X_N", s.given.X, "N_Nm", s.given.N);
  out["limited"] = limited;
  out["slot_needs"] = pair("u_mps", s.slot_needs.u, "r_radps", s.slot_needs.r);
  out["separation_m"] = s.separation_m;
  out["thrust_N"] = pair("port", s.thrust_N.port, "stbd", s.thrust_N.stbd);
  out["counters"] = counters_dict(s.counters);
  return out;
}

nb::dict parameters_dict(const app::Parameters& parameters) {
  nb::dict out;
  for (const app::ParameterInfo& info : app::kParameterList) {
    out[nb::str(info.name.data(), info.name.size())] = parameters.*(info.member);
  }
  return out;
}
