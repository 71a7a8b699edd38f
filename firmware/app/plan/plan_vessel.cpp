// SPDX-License-Identifier: MIT
#include "app/plan/plan_vessel.hpp"

#include <algorithm>
#include <utility>

#include "app/convert/convert_scalar.hpp"

namespace flotilla::app {
namespace {

constexpr float kLongestWay_m = 3000;  // the planner's tested range
static_assert(kPlanStart_m + kPlanReach_m <= kLongestWay_m && kErrandReach_m < kLongestWay_m);
// After this way the vessel measures again whether the next point is near enough.
constexpr int kFarther_m = 50;
constexpr int kNear_m = 1;  // the vessel slows down while the boat is farther away than this
// Steps of the scout between two samples of the future.
constexpr int kSteps = 5;
constexpr float kLeastCut = 0.25F;  // of the margin from a fence

}  // namespace

template <class S>
void PlanVessel<S>::start(const PlanOrder& order, const PlanDefaults& defaults,
                          const core::RouteParams<S>& limits, const convert::Position& own,
                          const core::Motion<S>& motion, S steerage) {
  from_ = own;
  start_m_ = order.start_m;
  fence_ = order.fence;
  margin_m_ = defaults.margin_m;
  first_ = {static_cast<std::uint16_t>(order.first), order.progress.jumps()};
  limits_ = limits;
  points_[0] = {};
  marks_ = {};
  count_ = 1;
  unread_ = false;
  sound_ = true;
  seen_ = 0;
  reader_.begin({order.first, convert::global_of(own), order.home, order.progress, order.pauses,
                 order.voyage_is_over},
                defaults);
  fill(order.plan);
  state_ = core::route_start(limits_, points());
  const S off = core::wrap_pi(state_.motion.psi - motion.psi);
  const bool on_course = core::abs(off) < S(0.5) && steerage < motion.nu.u;
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
void PlanVessel<S>::change(const PlanOrder& order, const PlanDefaults& defaults,
                           const core::RouteParams<S>& limits) {
  const core::Motion<S> before = state_.motion;
  start(order, defaults, limits, place(), before, S(0));
  if (state_.phase != core::RoutePhase::kWait || count_ < 2) return;
  state_.phase = core::RoutePhase::kTurn;
  state_.motion.nu.r = before.nu.r;
}

/// Reads a limited number of points: a plan whose jumps repeat a single place ends there.
template <class S>
void PlanVessel<S>::fill(Plan plan) {
  std::size_t left = 2 * plan.size() + kWindow;
  while (count_ < kWindow && left-- > 0) {
    PlanReader reader = reader_;
    const auto point = reader.next(plan);
    unread_ = point && !add(*point);
    if (unread_) return;
    reader_ = reader;
    if (!point) return;
  }
}

/// False: the point is beyond the planner's range until the vessel has come nearer. Where that is
/// known only on the way to the point before it, the vessel stops there.
template <class S>
bool PlanVessel<S>::add(const PlanPoint& point) {
  const auto [way, near] = convert::way_to<S>(from_, point.place, kLongestWay_m);
  if (!near && count_ > 1) return false;
  core::Waypoint<S>& last = points_[count_ - 1];
  const S wait = convert::scalar<S>(std::min(point.wait_s, kLongestWait_s));
  const S leg = core::hypot(way.x - last.place.x, way.y - last.place.y);
  sound_ = sound_ && (count_ > 1 || (near && leg <= convert::scalar<S>(start_m_)));
  if (leg < S(0.001) * S(core::kShortestLeg_mm)) {
    last.wait = core::min(last.wait, convert::scalar<S>(kLongestWait_s) - wait) + wait;
    PlanMark& mark = marks_[count_ - 1];
    const PlanMark before = std::exchange(mark, point.mark);
    if (mark.home == PlanMark::kNone) mark.home = before.home;
    mark.pauses = mark.pauses || before.pauses;
    return true;
  }
  if (count_ > 1) round_less(points_[count_ - 2].place, last, way);
  points_[count_] = {way, convert::scalar<S>(point.speed_mps), convert::scalar<S>(point.radius_m),
                     wait};
  marks_[count_] = point.mark;
  ++count_;
  return true;
}

/// Rounds a corner less until the curve keeps three quarters of the margin from the fence, or is a
/// quarter of it from the waypoint. Judges two chords and what lies between their meeting and the
/// waypoint: the curve is between them and the legs, but for 4 % of the distance at its ends.
template <class S>
void PlanVessel<S>::round_less(const core::Vec2<S>& before, core::Waypoint<S>& corner,
                               const core::Vec2<S>& after) const {
  if (fence_ == nullptr || !fence_->is_on()) return;
  const core::Vec2<S>& here = corner.place;
  core::Vec2<S> a{before.x - here.x, before.y - here.y}, b{after.x - here.x, after.y - here.y};
  const S to_a = core::hypot(a.x, a.y), to_b = core::hypot(b.x, b.y);
  a = {a.x / to_a, a.y / to_a}, b = {b.x / to_b, b.y / to_b};
  const core::Vec2<S> sum{a.x + b.x, a.y + b.y};
  const S twice_sin = core::hypot(sum.x, sum.y);  // of half of the turn
  if (twice_sin < S(0.02)) return;
  const core::Vec2<S> middle{sum.x / twice_sin, sum.y / twice_sin};
  // Where an arc leaves the leg, for each metre that it passes from the waypoint.
  const S along = (S(2) + core::hypot(a.x - b.x, a.y - b.y)) / twice_sin;
  corner.reach = core::min(corner.reach, S(0.5) * core::min(to_a, to_b) / along);
  const auto on_map = [&](S far, const core::Vec2<S>& e) {
    return fence_->on_map(
        {from_.north_m + here.x + far * e.x, from_.east_m + here.y + far * e.y, from_.origin});
  };
  const auto waypoint = on_map(S(0), middle);
  if (!waypoint) return;
  const Fence::Length clearance = fence_->clearance(*waypoint);
  const auto least = convert::scalar<core::Q16>((1 - kLeastCut) * margin_m_);
  const S cut = convert::scalar<S>(kLeastCut * margin_m_);
  for (; cut < corner.reach; corner.reach = core::max(S(0.5) * corner.reach, cut)) {
    const S far = along * corner.reach;
    if (!(clearance < least + convert::q16(far))) return;  // the curve is nowhere farther away
    const auto p = on_map(far, a), q = on_map(corner.reach, middle), r = on_map(far, b);
    if (!p || !q || !r) return;
    const auto clear = [&](const Fence::Place& end) { return fence_->clearance(*q, end); };
    if (!(core::min(core::min(clear(*p), clear(*r)), clear(*waypoint)) < least)) return;
  }
}

/// Measures places and motion from the vessel's present place.
template <class S>
void PlanVessel<S>::move_base() {
  const core::Vec2<S> moved = state_.motion.moved_n;
  from_ = place();
  const auto shift = [&](core::Vec2<S>& p) { p = {p.x - moved.x, p.y - moved.y}; };
  for (std::size_t i = 0; i < count_; ++i) shift(points_[i].place);
  for (core::RouteState<S>* vessel : {&state_, &scout_}) {
    shift(vessel->from);
    shift(vessel->motion.moved_n);
  }
}

/// Share of its speed at which the vessel sails.
template <class S>
S pace(const BoatBehind<S>& boat, S speed, bool paused) {
  if (paused) return S(0);
  const S share = core::clamp((boat.far_m - boat.off_m) / (boat.far_m - S(kNear_m)), S(0), S(1));
  return S(0) < boat.most_mps && boat.most_mps < speed ? core::min(share, boat.most_mps / speed)
                                                       : share;
}

template <class S>
void PlanVessel<S>::drive(const core::Drive<S>& desired, const BoatBehind<S>& boat, bool paused,
                          S dt) {
  constexpr int kLongWay_m = 500;
  if (!(S(0) < dt)) return;
  core::Motion<S>& motion = state_.motion;
  if (S(kLongWay_m) < core::abs(motion.moved_n.x) || S(kLongWay_m) < core::abs(motion.moved_n.y)) {
    from_ = place();
    motion.moved_n = {};
  }
  const S share = pace(boat, core::abs(desired.u), paused);
  seen_ = 0;
  foresees_ = false;
  const auto course = paused ? std::nullopt : desired.course;
  core::drive_forward(limits_, {share * desired.u, share * desired.r, course}, state_, dt);
}

template <class S>
void PlanVessel<S>::forward(Plan plan, const BoatBehind<S>& boat, bool paused, S dt) {
  constexpr std::size_t kPassed = 3;  // points behind that are kept
  if (!(S(0) < dt)) return;           // a tick in which the clock stood still
  const S share = pace(boat, points_[std::min(state_.next, count_ - 1)].speed, paused);
  advance(state_, share, dt);
  look_ahead(share, dt);
  const core::Vec2<S>& moved = state_.motion.moved_n;
  if (unread_ && core::is_longer(moved, S(kFarther_m))) {
    move_base();
    fill(plan);
  }
  if (state_.next <= kPassed) return;
  const std::size_t passed = state_.next - 1;
  scout_.next -= std::min(scout_.next, passed);
  std::shift_left(points_.begin(), points_.begin() + static_cast<std::ptrdiff_t>(count_),
                  static_cast<std::ptrdiff_t>(passed));
  std::shift_left(marks_.begin(), marks_.begin() + static_cast<std::ptrdiff_t>(count_),
                  static_cast<std::ptrdiff_t>(passed));
  count_ -= passed;
  state_.next = 1;
  fill(plan);
}

template <class S>
void PlanVessel<S>::advance(core::RouteState<S>& state, S share, S dt) const {
  core::route_forward(limits_, points(), state, share, dt);
}

/// Computes one sample of the future per tick. Begins anew every second, or already after 0.25 s
/// if the vessel slows down for the boat or speeds up again.
template <class S>
void PlanVessel<S>::look_ahead(S share, S dt) {
  constexpr std::size_t kSamples = core::kFutureSamples + 1;
  foreseen_.since = foreseen_.since + dt;
  const bool changed = S(0.1) < core::abs(share - share_) && S(0.25) < foreseen_.since;
  if (seen_ == 0 || changed || (seen_ == kSamples && !(foreseen_.since < S(1)))) {
    scout_ = state_;
    share_ = share;
    seen_ = 0;
    foreseen_.since = S(0);
  }
  if (seen_ == kSamples) return;
  for (int step = 0; step < kSteps && seen_ > 0; ++step) advance(scout_, share_, S(0.1));
  foreseen_.future.u[seen_] = scout_.motion.nu.u;
  foreseen_.future.r[seen_] = scout_.motion.nu.r;
  if (++seen_ == kSamples) foresees_ = true;
}

template <class S>
std::optional<typename PlanVessel<S>::Foreseen> PlanVessel<S>::take_future() {
  constexpr int kSteadyTold = 3;  // of this many steady futures in a row, one is not sent
  if (!std::exchange(foresees_, false)) return std::nullopt;
  const auto steady = [](const auto& samples) {
    return std::ranges::all_of(samples, [&](S x) { return x == samples[0]; });
  };
  const bool changes = !steady(foreseen_.future.u) || !steady(foreseen_.future.r);
  untold_ = changes ? 0 : untold_ + 1;
  if (untold_ % kSteadyTold > 1) return std::nullopt;
  return foreseen_;
}

template <class S>
void PlanVessel<S>::foresee(std::span<core::Motion<S>> motions, int every_s) const {
  core::RouteState<S> state = state_;
  for (core::Motion<S>& motion : motions) {
    motion = state.motion;
    for (int step = 0; step < 4 * every_s; ++step) advance(state, S(1), S(0.25));
  }
}

template <class S>
bool PlanVessel<S>::is_under_way() const {
  using enum core::RoutePhase;
  return state_.phase == kLeg || state_.phase == kCorner;
}

template <class S>
std::optional<std::size_t> PlanVessel<S>::reached() const {
  const PlanMark& mark = marks_[reached_point()];
  return mark.is_item() ? std::optional<std::size_t>(mark.item) : std::nullopt;
}

template <class S>
std::optional<std::size_t> PlanVessel<S>::take_home() {
  const std::uint16_t home = std::exchange(marks_[reached_point()].home, PlanMark::kNone);
  return home != PlanMark::kNone ? std::optional<std::size_t>(home) : std::nullopt;
}

template <class S>
bool PlanVessel<S>::take_pause() {
  return is_under_way() && std::exchange(marks_[reached_point()].pauses, false);
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
