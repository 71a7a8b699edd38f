// SPDX-License-Identifier: MIT
#include "app/guidance/plan_vessel.hpp"

#include <algorithm>

#include "app/convert/convert_scalar.hpp"

namespace flotilla::app {
namespace {

constexpr float kLongestWay_m = 3000;  // the planner's tested range
static_assert(kPlanStart_m + kPlanReach_m <= kLongestWay_m && kErrandReach_m < kLongestWay_m);
// The vessel waits for a boat that is so far from it, and slows down from the first of these on.
constexpr int kNear_m = 1, kFar_m = 3;

}  // namespace

template <class S>
void PlanVessel<S>::start(const Voyage& voyage, const PlanDefaults& defaults,
                          const core::RouteParams<S>& limits, const convert::Position& own,
                          const core::Motion<S>& motion) {
  from_ = own;
  start_m_ = voyage.start_m;
  limits_ = limits;
  points_[0] = {};
  items_ = {};
  count_ = 1;
  sound_ = true;
  reader_.begin(voyage.plan, voyage.first, defaults, voyage.home);
  fill(voyage.plan);
  state_ = core::route_start(limits_, points());
  const S off = core::wrap_pi(state_.motion.psi - motion.psi);
  const bool on_course = core::abs(off) < S(0.5) && S(0.1) < motion.nu.u;
  if (count_ < 2) {
    state_.motion.psi = motion.psi;
    state_.phase = core::RoutePhase::kWait;
    state_.left = points_[0].wait;
  } else if (on_course && !(S(0) < points_[0].wait)) {
    state_.motion.nu.u = core::min(motion.nu.u, points_[1].speed);
  } else {
    state_.motion.psi = motion.psi;
    state_.next = 0;
    state_.left = points_[0].wait;
    state_.phase = core::RoutePhase::kWait;
  }
}

template <class S>
void PlanVessel<S>::fill(Plan plan) {
  while (count_ < kWindow) {
    const auto point = reader_.next(plan);
    if (!point) return;
    add(*point);
  }
}

template <class S>
void PlanVessel<S>::add(const PlanPoint& point) {
  const auto [way, near] = convert::way_to<S>(from_, point.place, kLongestWay_m);
  core::Waypoint<S>& last = points_[count_ - 1];
  const S wait = convert::scalar<S>(std::min(point.wait_s, kLongestWait_s));
  const S leg = core::hypot(way.x - last.place.x, way.y - last.place.y);
  sound_ = sound_ && near && (count_ > 1 || leg <= convert::scalar<S>(start_m_));
  if (leg < S(0.001) * S(core::kShortestLeg_mm)) {
    last.wait = core::min(last.wait, convert::scalar<S>(kLongestWait_s) - wait) + wait;
    items_[count_ - 1] = point.item;
    return;
  }
  points_[count_] = {way, convert::scalar<S>(point.speed_mps), convert::scalar<S>(point.radius_m),
                     wait};
  items_[count_] = point.item;
  ++count_;
}

/// Share of its speed that the vessel sails with before a boat that far from it.
template <class S>
S pace(S off_m, bool paused) {
  if (paused) return S(0);
  return core::clamp((S(kFar_m) - off_m) / S(kFar_m - kNear_m), S(0), S(1));
}

template <class S>
void PlanVessel<S>::drive(const core::Drive<S>& desired, S off_m, bool paused, S dt) {
  constexpr int kLongWay_m = 500;
  if (!(S(0) < dt)) return;
  core::Motion<S>& motion = state_.motion;
  if (S(kLongWay_m) < core::abs(motion.moved_n.x) || S(kLongWay_m) < core::abs(motion.moved_n.y)) {
    from_ = place();
    motion.moved_n = {};
  }
  const S share = pace(off_m, paused);
  core::drive_forward(limits_, {share * desired.u, share * desired.r, desired.course}, state_, dt);
}

template <class S>
void PlanVessel<S>::forward(Plan plan, S off_m, bool paused, S dt) {
  constexpr std::size_t kPassed = 3;  // points behind that are kept
  if (!(S(0) < dt)) return;           // a tick in which the clock stood still
  core::route_forward(limits_, points(), state_, pace(off_m, paused), dt);
  if (state_.next <= kPassed) return;
  const std::size_t passed = state_.next - 1;
  std::shift_left(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(count_),
                  static_cast<std::ptrdiff_t>(passed));
  std::shift_left(items_.begin(), items_.begin() + static_cast<std::ptrdiff_t>(count_),
                  static_cast<std::ptrdiff_t>(passed));
  count_ -= passed;
  state_.next = 1;
  fill(plan);
}

template <class S>
std::optional<std::size_t> PlanVessel<S>::reached() const {
  using enum core::RoutePhase;
  const bool under_way = state_.phase == kLeg || state_.phase == kCorner;
  return items_[under_way ? state_.next - 1 : state_.next];
}

template <class S>
convert::Position PlanVessel<S>::place() const {
  const core::Vec2<S>& moved = state_.motion.moved_n;
  return {from_.north_m + moved.x, from_.east_m + moved.y, from_.origin};
}

template class PlanVessel<float>;
template class PlanVessel<double>;
template class PlanVessel<core::Q16>;

}  // namespace flotilla::app
