// SPDX-License-Identifier: MIT
// Boat: sails its plan in AUTO; a voyage that measures the hull without the law.
#include "app/boat.hpp"

namespace flotilla::app {

/// By the law, but for a voyage that measures the hull.
template <class S>
void Boat<S>::sail_plan(std::int64_t now_us, S dt) {
  const MissionService& missions = vehicle_.missions();
  if (vehicle_.missions().take_jump()) {
    voyage_.forget();
    start_plan();
  }
  if (!voyage_.is_on()) begin_voyage();
  if (voyage_.is_on()) {
    law_output_ = {};
    law_output_.allocation.thrust = sail_voyage(now_us, dt);
    if (voyage_.is_over()) start_plan();
  } else {
    law_output_ = pilot_.sail(missions.plan(), vehicle_.is_paused(), now_us, dt);
  }
  const PlanVessel<S>& sailed = pilot_.plan_vessel();
  auto reached = sailed.reached();
  if (!reached && voyage_.is_over()) reached = voyage_.item();
  vehicle_.sailed(sailed.item(), reached, sailed.has_arrived(), counters_);
}

/// Where the plan has come to one, and the boat is in its room.
template <class S>
void Boat<S>::begin_voyage() {
  const MissionService& missions = vehicle_.missions();
  const std::size_t at = pilot_.plan_vessel().item();
  const PlanItem& ahead = missions.plan()[at];
  const std::uint32_t plan = missions.id(Stored::kPlan);
  if (!is_voyage(ahead) || (voyage_.is_of(plan, at) && voyage_.is_over())) return;
  VoyageRoom room = room_of(ahead, configuration().plan, configuration().stopping);
  room.plan = plan;
  room.item = at;
  const bool inside = convert::way_to<S>(pilot_.place(), {ahead.x, ahead.y}, room.radius_m).near;
  if (inside) voyage_.begin(room);
}

template <class S>
core::Thrust<S> Boat<S>::sail_voyage(std::int64_t now_us, S dt) {
  const VoyageRoom& room = voyage_.room();
  const PlanItem& centre = vehicle_.missions().plan()[room.item];
  const core::Motion<S> motion = pilot_.seen_motion(now_us);
  convert::Position here = pilot_.seen_from();
  here.north_m = here.north_m + motion.moved_n.x;
  here.east_m = here.east_m + motion.moved_n.y;
  const float far_m = 2 * room.radius_m;
  const auto [way, near] = convert::way_to<S>(here, {centre.x, centre.y}, far_m);
  const core::Vec2<S> v_n =
      core::to_north_east(motion.psi, core::Vec2<S>{motion.nu.u, motion.nu.v});
  if (way_due_.take_if_due(now_us)) {
    const S rest_s = convert::scalar<S>(room.rest_s);
    voyage_at_fence_ = leaves_fence(here, {rest_s * v_n.x, rest_s * v_n.y});
  }
  const bool waits = vehicle_.is_paused() || (conditions_ & core::kClear) == 0;
  const auto off_n =
      near ? core::Vec2<S>{-way.x, -way.y} : core::Vec2<S>{convert::scalar<S>(far_m), S(0)};
  const core::Thrust<S> share =
      voyage_.forward({off_n, v_n, motion.psi, motion.nu.r, waits, voyage_at_fence_}, dt);
  if (const auto news = voyage_.take_news()) tell_voyage(*news);
  const core::AllocationParams<S>& propellers = pilot_.law().propellers;
  const auto thrust = [&](S q) { return (q < S(0) ? propellers.R : propellers.F) * q; };
  return {thrust(share.port), thrust(share.stbd)};
}

/// Whether a boat that goes on that way leaves the stored fence, or the circle round home.
template <class S>
bool Boat<S>::leaves_fence(const convert::Position& here, const core::Vec2<S>& way) const {
  convert::Position there = here;
  there.north_m = there.north_m + way.x;
  there.east_m = there.east_m + way.y;
  const auto& limit_m = configuration().failsafes.fence_m;
  const auto home = limits_.home();
  if (limit_m && home &&
      !convert::way_to<S>(there, {home->latitude, home->longitude}, *limit_m).near) {
    return true;
  }
  const Fence& fence = vehicle_.missions().fence();
  if (!fence.is_on()) return false;
  const float margin_m = configuration().plan.margin_m;
  return !fence.refusal_of(here, convert::global_of(there), margin_m).empty();
}

template <class S>
void Boat<S>::tell_voyage(const VoyageNews& news) {
  using enum VoyageNews::Kind;
  const auto count = static_cast<float>(kVoyageSteps.size());
  Sentence text;
  text << "Voyage: ";
  if (news.kind == kOver) {
    text << "over, " << static_cast<float>(news.step) << " of " << count << " steps whole";
  } else if (news.kind == kLost) {
    text << "the boat does not come back to its room";
  } else {
    text << "step " << static_cast<float>(news.step);
    if (news.kind == kBegins) text << " of " << count << ", ";
    if (news.kind == kAgain) text << " again: ";
    if (news.kind == kLeftOut) text << " left out: ";
    text << news.what;
  }
  const std::uint8_t severity =
      news.kind == kLost ? link::mav::kSeverityError : link::mav::kSeverityInfo;
  vehicle_.send_statustext(severity, {text.text()}, counters_);
}

template void Boat<float>::sail_plan(std::int64_t, float);
template void Boat<double>::sail_plan(std::int64_t, double);
template void Boat<core::Q16>::sail_plan(std::int64_t, core::Q16);

}  // namespace flotilla::app
