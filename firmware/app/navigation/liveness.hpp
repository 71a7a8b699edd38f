// SPDX-License-Identifier: MIT
// Detects frozen instruments, which repeat the same state.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "app/convert/convert.hpp"

namespace flotilla::app {

/// Frozen: the position stays bit-identical although the reported velocity would have moved it, the
/// heading likewise despite a yaw rate, or the whole state while the propellers push. A position
/// with noise is frozen if it stays within 0.15 m for 2 s although the reported velocity would have
/// moved it by 1 m; then only another position shows that it is live again. A vessel at rest that
/// reports no velocity is not frozen. A vessel that has never moved may be held in place, so it
/// gets 5 s; while the propellers push, it gets 8 s of thrust, because simulated boats are held
/// while they start.
template <class S>
class Liveness {
 public:
  /// patience_s: the shortest repetition that counts as frozen.
  explicit Liveness(S patience_s) : patience_s_(patience_s) {}

  /// A state, h seconds after the previous one; 0 if it does not continue that one.
  void take(const convert::Sample<S>& sample, S h) {
    const bool stays = sample.north_m == north_m_ && sample.east_m == east_m_;
    const bool heads = sample.psi_rad == psi_rad_;
    const core::Nu<S> nu = convert::nu_of(sample);
    if (!is_near(sample.north_m, near_north_m_) || !is_near(sample.east_m, near_east_m_)) {
      near_ = {};
      left_ = left_ || S(0) < h;
      near_north_m_ = sample.north_m, near_east_m_ = sample.east_m;
    } else if (stays || near_.time >= kBrief_s) {
      const auto v_n = core::to_north_east(sample.psi_rad, core::Vec2<S>{nu.u, nu.v});
      if (!strays()) near_.stay(v_n, h);
      place_.stay(v_n, h);
    } else {
      near_.Stuck::stay(h);
    }
    if (!stays) place_ = {};
    if (heads) {
      heading_.stay({nu.r, S(0)}, h);
    } else {
      heading_ = {};
    }
    const bool same = stays && heads && nu.u == nu_.u && nu.v == nu_.v && nu.r == nu_.r;
    if (same) {
      whole_.stay(h);
      if (!moved_ && !(kPushed < pushed_)) whole_.time = S(0);
      pushed_ = left_after(h) * pushed_;
    } else {
      whole_ = {};
      pushed_ = S(0);
    }
    moved_ = moved_ || (S(0) < h && !stays);
    north_m_ = sample.north_m, east_m_ = sample.east_m, psi_rad_ = sample.psi_rad, nu_ = nu;
    const bool sails = stays && nu.u * nu.u + nu.v * nu.v > kSlow * kSlow;
    judge(!sails && !(heads && core::abs(nu.r) > kSlow) && pushed_ <= kSlow);
  }

  /// Another sender, or a restarted one: its position may rest where the last one was.
  void forget_place() { near_ = {}; }

  /// Change of velocity by the propellers alone since the last call, m/s and rad/s.
  void push(S change) { pushed_ = core::min(pushed_ + change, S(2) * kPushed); }

  bool live() const { return live_; }

  /// It has reported two different positions.
  bool moved() const { return moved_; }

 private:
  static constexpr S kForgetting_per_s = S(0.2), kHeld_s = S(5), kPushedHeld_s = S(8);
  static constexpr S kContradicts = S(0.15);  ///< m, rad: well above any message's rounding
  static constexpr S kPushed = S(0.1);        ///< m/s, rad/s
  static constexpr S kSlow = S(0.05);         ///< m/s, rad/s: counts as at rest
  /// A position that stays within kNear_m, more than the noise of precise ones, for kNear_s,
  /// although the velocity leads kFar_m away, is frozen.
  static constexpr Metres kNear_m = Metres(0.15);
  static constexpr S kNear_s = S(2), kFar_m = S(1);
  /// A boat under way leaves within this time. Until then its velocity is not integrated, which
  /// saves time.
  static constexpr S kBrief_s = S(0.5);
  static constexpr int kFew = 3;  ///< messages

  static S left_after(S h) { return S(1) - core::min(kForgetting_per_s * h, S(1)); }

  /// How long a quantity has been repeated.
  struct Stuck {
    S time{};
    int repeats = 0;

    void stay(S h) {
      time = core::min(time + h, S(2) * kHeld_s);
      repeats = std::min(repeats + 1, kFew);
    }
    bool lasts(S s) const { return time >= s && repeats == kFew; }
  };

  /// The same, and how far the quantity's reported rate would have moved it since.
  struct Led : Stuck {
    core::Vec2<S> way{};

    void stay(const core::Vec2<S>& rate, S h) {
      const S left = left_after(h);
      way = {left * way.x + h * rate.x, left * way.y + h * rate.y};
      Stuck::stay(h);
    }
    /// The reported rate contradicts the repetition.
    bool contradicts() const { return core::hypot(way.x, way.y) > kContradicts; }
  };

  static bool is_near(Metres a, Metres b) { return a - b < kNear_m && b - a < kNear_m; }

  /// The velocity reported since the position came near here would have moved it far away.
  bool strays() const {
    return near_.lasts(left_ ? kNear_s : kHeld_s) && core::is_longer(near_.way, kFar_m);
  }

  void judge(bool well) {
    const S most_s = moved_ ? patience_s_ : kHeld_s;
    const bool frozen = strays() || (place_.lasts(most_s) && place_.contradicts()) ||
                        (heading_.lasts(most_s) && heading_.contradicts()) ||
                        (pushed_ > kPushed && whole_.lasts(moved_ ? patience_s_ : kPushedHeld_s));
    well_ = well && !frozen ? std::min(well_ + 1, kFew) : 0;
    live_ = !frozen && (live_ || well_ == kFew);
  }

  S patience_s_;
  Metres north_m_, east_m_, near_north_m_, near_east_m_;
  S psi_rad_{};
  core::Nu<S> nu_{};
  Led place_, near_, heading_;
  Stuck whole_;
  S pushed_{};
  int well_ = 0;
  bool moved_ = false;  ///< to another position
  bool left_ = false;   ///< by more than noise
  bool live_ = true;
};

}  // namespace flotilla::app
