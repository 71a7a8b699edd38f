// SPDX-License-Identifier: MIT
#include "app/boat/report.hpp"

#include <tuple>

#include "app/convert/convert_scalar.hpp"

namespace flotilla::app {
namespace {

// Followers keep the formation's reference through a COAST of their leader shorter than this.
constexpr std::int64_t kShortCoast_us = 1'000'000;

template <class S>
bool error_known(const Parts<S>& boat) {
  return boat.seen() || core::sails_alone(boat.state());
}

template <class S>
bool in_slot(const Parts<S>& boat) {
  return boat.keeps_slot() && boat.guidance.in_slot();
}

template <class S>
std::optional<double> separation_m(const core::ControllerOutput<S>& law) {
  const auto& [yielding, known, predicted] = law.separation;
  return known ? std::optional(convert::number(predicted)) : std::nullopt;
}

/// The law's errors and limits; nothing while the error from the slot is unknown.
template <class S>
std::optional<FormationReport> formation_of(const Parts<S>& boat) {
  if (!error_known(boat)) return std::nullopt;
  const bool judged = boat.keeps_slot() && boat.configuration().formation.judges_station;
  return FormationReport{judged ? std::optional(in_slot(boat)) : std::nullopt,
                         convert::in_double(boat.law.error.e),
                         convert::in_double(boat.law.desired.nu_star),
                         convert::in_double(boat.law.allocation.missing)};
}

template <class S>
void report_motion(const Parts<S>& boat, std::int64_t now_us, Report& out) {
  const Guidance<S>& guidance = boat.guidance;
  if ((boat.met & core::kOwnFresh) != 0) {
    out.own = OwnReport{convert::boot_ms(now_us), guidance.own_state(now_us), guidance.located()};
    out.estimates = guidance.estimates();
    out.gps = guidance.gps(now_us);
  }
  out.formation = formation_of(boat);
  out.reference = reference_of(boat, now_us);
  out.depth = guidance.depth();
  out.separation_m = separation_m(boat.law);
  out.own_age_s = guidance.own_age_s(now_us);
  out.leader_age_s = guidance.leader_age_s(now_us);
  out.leader_uncertainty_m = guidance.leader_uncertainty_m(now_us);
  out.leader = core::sails_alone(boat.state()) ? boat.vehicle.self().system : guidance.leader();
}

template <class S>
void report_limits(const Parts<S>& boat, Report& out) {
  const Configuration::Failsafes& failsafes = boat.configuration().failsafes;
  const Fence& fence = boat.vehicle.missions().fence();
  out.home = boat.limits.home();
  out.fenced = failsafes.fence_m.has_value() || fence.is_stored();
  out.fence_is_off = fence.is_stored() && !fence.is_on() && !failsafes.fence_m;
  if (fence.is_stored()) out.fence = boat.fence_watch.report();
  out.battery_limited = failsafes.battery_V.has_value();
}

}  // namespace

template <class S>
std::optional<link::FormationReference> reference_of(const Parts<S>& boat, std::int64_t now_us) {
  const auto since_us = boat.supervisor.coasting_since_us();
  const bool coasts = since_us && now_us - *since_us < kShortCoast_us;
  return boat.guidance.reference(now_us, boat.keeps_slot() || coasts);
}

template <class S>
Report report_of(const Parts<S>& boat, std::int64_t now_us) {
  Report out;
  out.now_us = now_us;
  out.unix_us = boat.host.unix_us;
  out.overruns = boat.host.overruns;
  out.conditions = boat.met;
  report_motion(boat, now_us, out);
  report_limits(boat, out);
  out.balance = boat.learnt.told(ModelMonitor::Number::kBalance);
  out.drag = boat.learnt.told(ModelMonitor::Number::kDrag);
  out.yaw_damping = boat.learnt.told(ModelMonitor::Number::kYawDamping);
  const Configuration::Propulsion& propulsion = boat.configuration().propulsion;
  const auto& [port, stbd] = boat.thrust.thrust;
  out.thrust = {convert::number(port), convert::number(stbd)};
  out.most_N = propulsion.ahead_N;
  out.least_N = -propulsion.astern_N;
  const auto esc = [&](std::uint8_t index) {
    return EscReport{index, boat.can.esc_status(index, now_us)};
  };
  out.escs = {esc(propulsion.port_esc), esc(propulsion.stbd_esc)};
  return out;
}

template <class S>
Snapshot snapshot_of(const Parts<S>& boat, std::int64_t now_us) {
  const auto& [guidance, law] = std::tie(boat.guidance, boat.law);
  const auto& [port, stbd] = boat.thrust.thrust;
  return {.state = boat.state(),
          .conditions = boat.met,
          .own_age_s = guidance.own_age_s(now_us),
          .leader_age_s = guidance.leader_age_s(now_us),
          .leader_uncertainty_m = guidance.leader_uncertainty_m(now_us),
          .reference_age_s = guidance.reference_age_s(now_us),
          .estimates = guidance.estimates(),
          .error_known = error_known(boat),
          .error = convert::in_double(law.error.e),
          .nu_star = convert::in_double(law.desired.nu_star),
          .asked = convert::in_double(law.tau),
          .given = convert::in_double(boat.thrust.given),
          .thrust_N = {convert::number(port), convert::number(stbd)},
          .limits = law.limits() | (boat.thrust.slew_limited ? core::kSlewLimit : 0),
          .slot_needs = convert::in_double(law.too_fast),
          .yielding = law.separation.yielding,
          .in_slot = in_slot(boat),
          .separation_m = separation_m(law),
          .counters = boat.counters};
}

#define FLOTILLA_REPORTS(S)                                        \
  template Report report_of<S>(const Parts<S>&, std::int64_t);     \
  template Snapshot snapshot_of<S>(const Parts<S>&, std::int64_t); \
  template std::optional<link::FormationReference> reference_of<S>(const Parts<S>&, std::int64_t);
FLOTILLA_REPORTS(float)
FLOTILLA_REPORTS(double)
FLOTILLA_REPORTS(core::Q16)
#undef FLOTILLA_REPORTS

}  // namespace flotilla::app
