// SPDX-License-Identifier: MIT
#include "app/plan/fence_watch.hpp"

#include <utility>

#include "app/convert/convert_scalar.hpp"
#include "core/rotation.hpp"
#include "core/separation.hpp"

namespace flotilla::app {
namespace {

using core::Q16;

constexpr int kFastest_mps = 20, kLongest_m = 2000;
constexpr Q16 kTolerance = Q16(0.1);  // of the clearance outside, m

Q16 way_to_rest(Q16 speed, const Configuration::Stopping& stopping) {
  const Q16 u = core::min(speed, Q16(kFastest_mps));
  const Q16 a = convert::scalar<Q16>(stopping.brake_mps2);
  const Q16 braking = Q16(0.5) * (u * u) / a, drifting = u * convert::scalar<Q16>(stopping.drag_s);
  const Q16 reacting = u * convert::scalar<Q16>(stopping.reaction_s);
  return core::min(reacting + core::max(braking, drifting), Q16(kLongest_m));
}

}  // namespace

void FenceWatch::look(const Fence& fence, const Configuration::Stopping& stopping,
                      const Seen& seen) {
  if (!fence.is_on()) {
    last_.reset();
    stays_ = true;
    report_.breached = false;
    return;
  }
  if (std::exchange(drawn_, fence.drawn()) != fence.drawn()) last_.reset();
  if (!seen.place) {
    stays_ = false;
    return;
  }
  if (const auto place = fence.on_map(*seen.place)) {
    stays_ = judge(fence, *place, seen.velocity_n, stopping);
    note(!(Q16(0) < last_->clearance), seen.now_us);
  } else {
    last_.reset();
    stays_ = fence.permits_far();
    note(!stays_, seen.now_us);
  }
}

/// The clearance changes by no more than the boat moves, so it is computed anew near a boundary only.
bool FenceWatch::judge(const Fence& fence, const Fence::Place& place,
                       const core::Vec2<Q16>& velocity_n, const Configuration::Stopping& stopping) {
  const Q16 speed = core::hypot(velocity_n.x, velocity_n.y);
  const Q16 rest = way_to_rest(speed, stopping);
  if (last_) {
    const Q16 moved = core::hypot(place.x - last_->place.x, place.y - last_->place.y);
    if (rest + moved < last_->clearance) return true;
  }
  last_ = Last{place, fence.clearance(place)};
  if (!(Q16(0) < last_->clearance)) return false;
  if (rest < last_->clearance) return true;
  const core::Vec2<Q16> way{core::scaled(rest, velocity_n.x, speed),
                            core::scaled(rest, velocity_n.y, speed)};
  return Q16(0) < fence.clearance(place, {place.x + way.x, place.y + way.y});
}

std::uint16_t FenceWatch::closed_courses(const Fence& fence, const convert::Position& place,
                                         const Configuration::Stopping& stopping, Q16 speed) {
  const auto here = fence.is_on() ? fence.on_map(place) : std::nullopt;
  if (!here) return 0;
  const Q16 now = fence.clearance(*here), reach = Q16(2) * way_to_rest(speed, stopping);
  if (reach < now) return 0;
  std::uint16_t closed = 0;
  for (unsigned k = 0; k < core::kCourses; ++k) {
    const Q16 angle = Q16(static_cast<int>(k)) * Q16(0.39269908169872414);  // π/8
    const core::Vec2<Q16> way = core::to_north_east(angle, core::Vec2<Q16>{reach, Q16(0)});
    const Q16 clear = fence.clearance(*here, {here->x + way.x, here->y + way.y});
    // On a leg that crosses an edge the clearance is 0.
    const bool leaves = Q16(0) < now ? !(Q16(0) < clear) : clear < now - kTolerance;
    if (leaves) closed = static_cast<std::uint16_t>(closed | 1U << k);
  }
  return closed;
}

void FenceWatch::note(bool outside, std::int64_t now_us) {
  if (std::exchange(report_.breached, outside) || !outside) return;
  if (report_.breaches < UINT16_MAX) ++report_.breaches;
  report_.last_ms = convert::boot_ms(now_us);
}

}  // namespace flotilla::app
