// SPDX-License-Identifier: MIT
#include "app/guidance/voyage_guidance.hpp"

#include <tuple>

#include "app/convert/convert_scalar.hpp"

namespace flotilla::app {
namespace {

template <class S>
convert::Position moved(const convert::Position& from, const core::Vec2<S>& way_n) {
  convert::Position to = from;
  to.north_m = to.north_m + way_n.x;
  to.east_m = to.east_m + way_n.y;
  return to;
}

template <class S>
core::Vec2<S> velocity_n(const core::Motion<S>& motion) {
  return core::to_north_east(motion.psi, core::Vec2<S>{motion.nu.u, motion.nu.v});
}

}  // namespace

template <class S>
void VoyageGuidance<S>::begin_plan(const VoyageId& at) {
  voyage_.interrupt();
  if (!voyage_.is_of(at)) voyage_.forget();
}

template <class S>
void VoyageGuidance<S>::begin(const PlanItem& ahead, const VoyageId& at,
                              const Guidance<S>& guidance, const Configuration& configuration) {
  if (!is_voyage(ahead) || (voyage_.is_of(at) && voyage_.is_over())) return;
  VoyageRoom room = room_of(ahead, configuration.plan, configuration.stopping);
  room.id = at;
  if (convert::way_to<S>(guidance.place(), {ahead.x, ahead.y}, room.radius_m).near) {
    voyage_.begin(room);
    voyage_.limit(speeds_of(configuration.plan));
  }
}

template <class S>
void VoyageGuidance<S>::look(const Guidance<S>& guidance, const Bounds& bounds,
                             const VoyageSpeeds& fastest, std::int64_t now_us) {
  voyage_.limit(fastest);
  const core::Motion<S> motion = guidance.seen_motion(now_us);
  const convert::Position here = moved(guidance.seen_from(), motion.moved_n);
  const core::Vec2<S> v_n = velocity_n(motion);
  const S rest_s = convert::scalar<S>(voyage_.room().rest_s);
  const convert::Position there = moved(here, core::Vec2<S>{rest_s * v_n.x, rest_s * v_n.y});
  const auto& [home, reach_m] = std::tie(bounds.home, bounds.reach_m);
  if (reach_m && home && !convert::way_to<S>(there, *home, *reach_m).near) {
    at_fence_ = true;
    return;
  }
  const Fence& fence = bounds.fence;
  at_fence_ =
      fence.is_on() && !fence.refusal_of(here, convert::global_of(there), bounds.margin_m).empty();
}

template <class S>
core::Thrust<S> VoyageGuidance<S>::forward(const Guidance<S>& guidance,
                                           const convert::GlobalPoint& centre, bool waits,
                                           std::int64_t now_us, S dt) {
  const core::Motion<S> motion = guidance.seen_motion(now_us);
  const convert::Position here = moved(guidance.seen_from(), motion.moved_n);
  const float far_m = 2 * voyage_.room().radius_m;
  const auto [way, near] = convert::way_to<S>(here, centre, far_m);
  const auto off_n =
      near ? core::Vec2<S>{-way.x, -way.y} : core::Vec2<S>{convert::scalar<S>(far_m), S(0)};
  const core::Thrust<S> share =
      voyage_.forward({off_n, velocity_n(motion), motion.psi, motion.nu.r, waits, at_fence_}, dt);
  const core::AllocationParams<S>& propellers = guidance.law().propellers;
  const auto thrust = [&](S q) { return (q < S(0) ? propellers.R : propellers.F) * q; };
  return {thrust(share.port), thrust(share.stbd)};
}

template class VoyageGuidance<float>;
template class VoyageGuidance<double>;
template class VoyageGuidance<core::Q16>;

}  // namespace flotilla::app
