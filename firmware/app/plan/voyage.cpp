// SPDX-License-Identifier: MIT
#include "app/plan/voyage.hpp"

#include <algorithm>
#include <utility>

#include "app/convert/convert_scalar.hpp"
#include "core/rotation.hpp"

namespace flotilla::app {
namespace {

namespace mav = link::mav;

constexpr float kShare = 0.8F, kLeastShare = 0.1F, kGreatestRadius_m = 500;
constexpr int kLeastRadius_m = 5;
constexpr float kFastest_radps = 2;
constexpr int kTries = 3;
constexpr int kRest_s = 3, kTurn_s = 15, kReturn_s = 180;

bool goes_far(Manoeuvre manoeuvre) {
  using enum Manoeuvre;
  return manoeuvre == kAhead || manoeuvre == kAstern || manoeuvre == kZigZag ||
         manoeuvre == kRandom;
}

}  // namespace

bool is_voyage(const PlanItem& item) {
  return FLOTILLA_SAILS_VOYAGES != 0 && item.command == mav::kVoyage;
}

PlanFault fault_of_voyage(const PlanItem& item) {
  const float share = or_zero(item.param[0]), radius_m = or_zero(item.param[1]);
  if (share != 0 && !(share >= kLeastShare && share <= 1)) {
    return {mav::kMissionInvalidParam1, "thrust must be 0.1 to 1"};
  }
  if (radius_m != 0 && !(radius_m >= kLeastRadius_m && radius_m <= kGreatestRadius_m)) {
    return {mav::kMissionInvalidParam2, "radius must be 5 to 500 m"};
  }
  return {};
}

VoyageSpeeds speeds_of(const PlanDefaults& defaults) {
  return {.mps = defaults.fastest_mps > 0 ? defaults.fastest_mps : kPlanFastest_mps,
          .radps = defaults.fastest_radps > 0 ? std::min(defaults.fastest_radps, kFastest_radps)
                                              : kFastest_radps};
}

VoyageRoom room_of(const PlanItem& item, const PlanDefaults& defaults,
                   const Configuration::Stopping& stopping) {
  const float share = or_zero(item.param[0]), radius_m = or_zero(item.param[1]);
  const float braking_s = speeds_of(defaults).mps / (2 * stopping.brake_mps2);
  return {.radius_m = radius_m > 0 ? radius_m : defaults.room_m,
          .share = share > 0 ? share : kShare,
          .rest_s = std::min(stopping.reaction_s + std::max(stopping.drag_s, braking_s), 60.0F)};
}

template <class S>
void HullVoyage<S>::begin(const VoyageRoom& room) {
  if (!is_of(room.id)) forget();
  room_ = room;
  radius_ = convert::scalar<S>(room.radius_m);
  greatest_ = radius_;
  gain_ = convert::scalar<S>(room.share);
  rest_s_ = convert::scalar<S>(room.rest_s);
  enter(Phase::kRest);
}

template <class S>
void HullVoyage<S>::limit(const VoyageSpeeds& fastest) {
  fastest_ = convert::scalar<S>(fastest.mps);
  fastest_r_ = convert::scalar<S>(fastest.radps);
}

template <class S>
void HullVoyage<S>::interrupt() {
  phase_ = Phase::kOff;
  lost_ = false;
}

template <class S>
void HullVoyage<S>::enter(Phase phase) {
  phase_ = phase;
  in_phase_s_ = S(0);
}

template <class S>
core::Thrust<S> HullVoyage<S>::forward(const Seen& seen, S dt) {
  in_phase_s_ = in_phase_s_ + dt;
  away_ = core::hypot(seen.off_n.x, seen.off_n.y);
  look(seen);
  advance(seen);
  const core::Thrust<S> asked = shares(seen, dt);
  return slowed(core::clamp(asked.port, S(-1), S(1)), core::clamp(asked.stbd, S(-1), S(1)));
}

/// Reduces thrust ahead and turning thrust separately: a boat that was too fast ahead still turns
/// with full thrust, because only that moves the hull sideways. If one propeller drives alone, the
/// other stays at 0.
template <class S>
core::Thrust<S> HullVoyage<S>::slowed(S port, S stbd) const {
  const bool alone = phase_ == Phase::kDriven && step().manoeuvre == Manoeuvre::kAlone;
  const S least = core::min(ahead_, turning_);
  const S both = S(0.5) * (alone ? least : ahead_) * (port + stbd);
  const S apart = S(0.5) * (alone ? least : turning_) * (port - stbd);
  return {gain_ * (both + apart), gain_ * (both - apart)};
}

/// Cuts off a step that cannot continue. A fence in the way makes the room smaller.
template <class S>
void HullVoyage<S>::look(const Seen& seen) {
  if (S(1.5) * greatest_ < away_) return lose();
  if (seen.waits) return enter(Phase::kRest);
  if (phase_ == Phase::kOff || phase_ == Phase::kRest) return;
  const S stops = core::hypot(seen.off_n.x + rest_s_ * seen.velocity_n.x,
                              seen.off_n.y + rest_s_ * seen.velocity_n.y);
  const S speed = core::hypot(seen.velocity_n.x, seen.velocity_n.y);
  const bool turns_fast = fastest_r_ < core::abs(seen.r);
  const S edge = S(0.95) * radius_;
  const bool too_fast = fastest_ < speed || turns_fast;
  const bool spins = phase_ != Phase::kReturn && step().manoeuvre == Manoeuvre::kSpin;
  S& factor = turns_fast || spins ? turning_ : ahead_;
  if (phase_ == Phase::kReturn) {
    if (too_fast && slow_down(factor)) enter(Phase::kRest);
  } else if (too_fast) {
    cut_off("too fast", slow_down(factor));
  } else if (seen.blocked) {
    radius_ = core::min(radius_, core::max(away_, S(kLeastRadius_m)));
    cut_off("the fence", false);
  } else if (edge < core::max(stops, away_)) {
    cut_off("no room", false);
  }
}

/// Reduces the thrust from now on; false if hardly any is left.
template <class S>
bool HullVoyage<S>::slow_down(S& factor) {
  const S slower = S(0.7) * factor;
  const bool can = S(0.1) < gain_ * slower;
  if (can) factor = slower;
  return can;
}

/// A step that is repeated with less thrust does not use up a try.
template <class S>
void HullVoyage<S>::cut_off(std::string_view why, bool slower) {
  enter(Phase::kRest);
  if (!slower) ++tries_;
  news_ = VoyageNews{VoyageNews::Kind::kAgain, step_ + 1, why};
  if (tries_ < kTries) return;
  news_->kind = VoyageNews::Kind::kLeftOut;
  next_step();
}

template <class S>
void HullVoyage<S>::lose() {
  phase_ = Phase::kOff;
  lost_ = true;
  news_ = VoyageNews{VoyageNews::Kind::kLost, step_ + 1};
}

template <class S>
void HullVoyage<S>::end_step() {
  ++whole_;
  next_step();
}

template <class S>
void HullVoyage<S>::next_step() {
  tries_ = 0;
  enter(Phase::kRest);
  if (++step_ < kVoyageSteps.size()) return;
  phase_ = Phase::kOff;
  news_ = VoyageNews{VoyageNews::Kind::kOver, whole_};
}

/// A step that goes far begins with a turn towards the room's centre, or away from it if it goes
/// astern.
template <class S>
void HullVoyage<S>::begin_step(const Seen& seen) {
  const S pi = S(3.14159265358979323846);
  const bool straight = step().manoeuvre == Manoeuvre::kStraight;
  const bool far = S(0.15) * radius_ < away_;
  const bool turns = straight || (far && goes_far(step().manoeuvre));
  course_ = seen.psi;
  if (straight) {
    course_ = core::wrap_pi(S(0.25) * pi * S(step().eighths_turn));
  } else if (turns) {
    const S ahead = step().port < 0 ? S(-1) : S(1);
    course_ = core::atan2(-ahead * seen.off_n.y, -ahead * seen.off_n.x);
  }
  swapped_ = false;
  chip_s_ = S(0);
  register_ = 1;
  enter(turns ? Phase::kTurn : Phase::kDriven);
  news_ = VoyageNews{VoyageNews::Kind::kBegins, step_ + 1, name_of(step().manoeuvre)};
}

/// Changes from one phase to the next.
template <class S>
void HullVoyage<S>::advance(const Seen& seen) {
  switch (phase_) {
    case Phase::kOff:
      break;
    case Phase::kRest:
      if (seen.waits || in_phase_s_ < S(kRest_s)) break;
      if (S(0.4) * radius_ < away_) {
        enter(Phase::kReturn);
      } else {
        begin_step(seen);
      }
      break;
    case Phase::kReturn:
      if (away_ < S(0.33) * radius_) {
        enter(Phase::kRest);
      } else if (S(kReturn_s) < in_phase_s_) {
        lose();
      } else {
        course_ = core::atan2(-seen.off_n.y, -seen.off_n.x);
      }
      break;
    case Phase::kTurn:
      if (core::abs(core::wrap_pi(course_ - seen.psi)) < S(0.2) || S(kTurn_s) < in_phase_s_) {
        enter(Phase::kDriven);
      }
      break;
    case Phase::kDriven:
      if (!(in_phase_s_ < S(step().driven_s))) enter(Phase::kCoasting);
      break;
    case Phase::kCoasting:
      if (!(in_phase_s_ < S(step().coasting_s))) end_step();
      break;
  }
}

template <class S>
core::Thrust<S> HullVoyage<S>::shares(const Seen& seen, S dt) {
  switch (phase_) {
    case Phase::kOff:
    case Phase::kRest:
    case Phase::kCoasting:
      return {};
    case Phase::kReturn: {
      const bool ahead = core::abs(core::wrap_pi(course_ - seen.psi)) < S(0.5);
      return steered(seen, ahead ? S(0.7) : S(0));
    }
    case Phase::kTurn:
      return steered(seen, S(0));
    case Phase::kDriven:
      break;
  }
  const S port = S(0.01) * S(step().port), stbd = S(0.01) * S(step().stbd);
  if (step().manoeuvre == Manoeuvre::kStraight) return steered(seen, port);
  return update_swapped(seen, dt) ? core::Thrust<S>{stbd, port} : core::Thrust<S>{port, stbd};
}

/// Steers to course_. The gains are weak enough for every hull: they are shares of its own thrust.
template <class S>
core::Thrust<S> HullVoyage<S>::steered(const Seen& seen, S surge) const {
  const S off = core::wrap_pi(course_ - seen.psi);
  const S d = core::clamp(S(0.8) * (off - seen.r), S(-0.5), S(0.5));
  return {surge + d, surge - d};
}

/// Updates whether the two propellers have exchanged their thrusts, and returns it.
template <class S>
bool HullVoyage<S>::update_swapped(const Seen& seen, S dt) {
  if (step().manoeuvre == Manoeuvre::kZigZag) {
    const S off = core::wrap_pi(seen.psi - course_);
    const S twenty_degrees = S(0.35);
    if (twenty_degrees < off) swapped_ = true;
    if (off < -twenty_degrees) swapped_ = false;
  }
  if (step().manoeuvre == Manoeuvre::kRandom) {
    chip_s_ = chip_s_ + dt;
    if (!(chip_s_ < S(1))) {
      chip_s_ = chip_s_ - S(1);
      // x⁶ + x⁵ + 1: all 63 words before one repeats.
      const unsigned bit = (register_ ^ register_ >> 1U) & 1U;
      register_ = register_ >> 1U | bit << 5U;
      swapped_ = bit != 0;
    }
  }
  return swapped_;
}

template <class S>
std::optional<VoyageNews> HullVoyage<S>::take_news() {
  return std::exchange(news_, std::nullopt);
}

template class HullVoyage<float>;
template class HullVoyage<double>;
template class HullVoyage<core::Q16>;

}  // namespace flotilla::app
