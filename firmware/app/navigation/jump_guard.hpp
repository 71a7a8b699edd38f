// SPDX-License-Identifier: MIT
// Ignores an implausible jump until it has been reported consistently for 1 s.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <optional>

#include "app/convert/convert.hpp"
#include "core/estimation/plausibility.hpp"

namespace flotilla::app {

/// A new place is believed when five states in a row, over at least 1 s, agree with each other and
/// none agrees with the old place. If two vessels send alternately, the first one is followed.
template <class S>
class JumpGuard {
 public:
  enum class Verdict : std::uint8_t {
    kGoesOn,
    kRefused,
    kMoved,  ///< the new place is believed; the jump does not count as motion
  };

  /// Limits of an unknown leader: the fastest model boat.
  static constexpr core::PlausibilityLimits<S> kAnyVessel{S(1),  S(0.8), S(2),  S(1.5),
                                                          S(40), S(60),  S(10), S(8)};

  void set_limits(const core::PlausibilityLimits<S>& limits) {
    limits_ = limits;
    small_ = core::small_move(limits);
  }
  const core::PlausibilityLimits<S>& limits() const { return limits_; }

  /// The next state is accepted without comparison.
  void forget() { last_.reset(), next_.reset(); }

  /// A reported state, and its arrival time.
  struct Seen {
    Metres north_m, east_m;
    S psi;
    core::Nu<S> nu;
    std::int64_t stamp_us, arrived_us;
  };
  static Seen seen(const convert::Sample<S>& s, std::int64_t now_us) {
    return {s.north_m, s.east_m, s.psi_rad, convert::nu_of(s), s.stamp_us, now_us};
  }

  /// Sets the state that the next one is compared with.
  void believe(const Seen& state) {
    last_ = state;
    next_.reset();
  }

  /// The state that the next one is compared with.
  const std::optional<Seen>& last() const { return last_; }

  /// For a state that arrives now with another clock's stamp: its latest possible stamp by the
  /// clock of the last state.
  std::int64_t stamp_after_last(std::int64_t now_us) const {
    return last_->stamp_us + (now_us - last_->arrived_us) + kSettled_us;
  }

  /// Takes a state given in the plane of the last one; `far`: too far away for that plane. Unless
  /// it is refused, call believe() next.
  [[nodiscard]] Verdict take(const Seen& state, bool far) {
    if (!last_) return Verdict::kGoesOn;
    const core::Leg<S> way = leg(*last_, state);
    if (!far && core::hardly_moves(small_, way)) {
      // Movement that the velocity explains is not scatter.
      const S speed = core::abs(way.from.u) + core::abs(way.from.v);
      const S moved = core::max(core::abs(way.moved_n.x), core::abs(way.moved_n.y));
      note_scatter(core::max(moved - way.h * speed, S(0)));
      return Verdict::kGoesOn;
    }
    const auto innovation = core::innovation_of(limits_, way, scatter_);
    if (!far && innovation.share <= S(1)) {
      note_scatter(innovation.off);
      return Verdict::kGoesOn;
    }
    const std::int64_t now_us = state.arrived_us;
    jumped_us_ = now_us;
    const bool agrees = next_ && can_be(*next_, state);
    if (!agrees) since_us_ = now_us;
    agreed_ = agrees ? std::min(agreed_ + 1, kRow) : 1;
    next_ = state;
    const bool settled = agreed_ == kRow && now_us - since_us_ >= kSettled_us;
    moved_ = moved_ || settled;
    return settled ? Verdict::kMoved : Verdict::kRefused;
  }

  /// Checks a state that is not used otherwise, an old one or one without a heading, and notes a
  /// jump if it cannot belong to the same vessel.
  void look_at(const Seen& state, bool heading_known) {
    if (!last_) return;
    const bool before = state.stamp_us < last_->stamp_us;
    const core::Leg<S> way = before ? leg(state, *last_) : leg(*last_, state);
    core::PlausibilityLimits<S> limits = limits_;
    if (!heading_known) limits.heading = limits.yaw_rate = S(100);
    if (core::innovation_of(limits, way, scatter_).share > S(1)) jumped_us_ = state.arrived_us;
  }

  /// Notes that the vessel has jumped and its new place is believed.
  void note_moved(std::int64_t now_us) {
    jumped_us_ = now_us;
    moved_ = true;
  }

  /// Notes an implausible report that the caller has found.
  void note_jump(std::int64_t now_us) { jumped_us_ = now_us; }

  /// A jump was believed since accept().
  bool moved() const { return moved_; }
  void accept() { moved_ = false; }

  /// No jump within the last second.
  bool steady(std::int64_t now_us) const {
    return !jumped_us_ || now_us - *jumped_us_ >= kSettled_us;
  }

 private:
  static constexpr int kRow = 5;
  static constexpr std::int64_t kSettled_us = 1'000'000;
  static constexpr std::int64_t kLongest_us = 60'000'000;  // between two states

  /// The two clocks may disagree: limits the interval to the time that passed here plus 1 s, the
  /// possible delay of the first state.
  static core::Leg<S> leg(const Seen& a, const Seen& b) {
    const std::int64_t apart_us = std::abs(b.arrived_us - a.arrived_us);
    const std::int64_t most_us = std::min(apart_us + kSettled_us, kLongest_us);
    const auto h_us = std::clamp<std::int64_t>(b.stamp_us - a.stamp_us, 0, most_us);
    return {{convert::limited<S>(b.north_m - a.north_m), convert::limited<S>(b.east_m - a.east_m)},
            a.psi,
            b.psi,
            a.nu,
            b.nu,
            convert::seconds<S>(h_us)};
  }
  bool can_be(const Seen& a, const Seen& b) const {
    return core::innovation_of(limits_, leg(a, b), scatter_).share <= S(1);
  }

  void note_scatter(S off) { scatter_ = scatter_ + S(0.1) * (off - scatter_); }

  core::PlausibilityLimits<S> limits_ = kAnyVessel;
  core::SmallMove<S> small_ = core::small_move(limits_);
  std::optional<Seen> last_, next_;
  S scatter_{};
  bool moved_ = false;
  int agreed_ = 0;
  std::int64_t since_us_ = 0;
  std::optional<std::int64_t> jumped_us_;
};

}  // namespace flotilla::app
