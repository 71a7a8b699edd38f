// SPDX-License-Identifier: MIT
#include "app/guidance/fence_watch.hpp"

#include <utility>

#include "app/convert/convert_scalar.hpp"

namespace flotilla::app {
namespace {

using core::Q16;

constexpr int kFastest_mps = 20, kLongest_m = 2000;

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

void FenceWatch::note(bool outside, std::int64_t now_us) {
  if (std::exchange(report_.breached, outside) || !outside) return;
  if (report_.breaches < UINT16_MAX) ++report_.breaches;
  report_.last_ms = convert::boot_ms(now_us);
}

}  // namespace flotilla::app
