// SPDX-License-Identifier: MIT
// The rules, each named by a sentence; rules.def is the list.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>

#include "link/mavlink/mav.hpp"
#include "policies/moment.hpp"

namespace flotilla::policies {

/// A pure function: holds(before, now).
struct Rule {
  std::string_view group;
  std::string_view name;
  bool (*holds)(const Seen& b, const Moment& n);
};

namespace rules {

using core::State;
namespace mav = link::mav;

inline std::int64_t us(float seconds) { return static_cast<std::int64_t>(double{seconds} * 1e6); }

/// Longest time between TIMESYNC requests.
inline double asks_s(const Moment& n) {
  const double slow_Hz = double{n.p->SR_SLOW};
  const double slow_s = 0 < slow_Hz && slow_Hz < 1 ? 1 / slow_Hz : 1;
  return 0.1 + (n.slow_link ? std::max(slow_s, 4.0) : slow_s);
}

/// Whether the newest state heard is younger than the limit, by the sender's true clock if known.
inline bool truly(double limit_s, const std::optional<std::int64_t>& clock_us, std::int64_t true_us,
                  const Moment& n) {
  return n.torn || !clock_us || n.within(limit_s, true_us);
}

inline float greatest_N(const Moment& n) {
  return n.p->THR_FWD_MAX < n.p->THR_REV_MAX ? n.p->THR_REV_MAX : n.p->THR_FWD_MAX;
}

/// Greatest change of thrust by one unit of RawCommand, where the curve is steepest.
inline float step_N(const Moment& n) { return 2.0F / 8191.0F * greatest_N(n); }

inline bool at_most(float thrust_N, const Moment& n) {
  constexpr float kRounded = 1.0001F;
  return thrust_N <= kRounded * n.p->THR_FWD_MAX && thrust_N >= -kRounded * n.p->THR_REV_MAX;
}

/// Whether a command and its thrust have the same sign, and neither is zero without the other.
/// Thrust below Q16's resolution of 16 µN, on the flattest curve, counts as zero.
inline bool agrees(std::int16_t command, float thrust_N, float direction, float most_N) {
  const float ahead = static_cast<float>(command) * direction / 8191.0F;
  if (thrust_N == 0) return most_N * ahead * ahead < 16e-6F;
  return ahead * thrust_N > 0;
}

inline bool slewed(std::int16_t before, std::int16_t now, const Moment& n) {
  constexpr float kFull = 8191.0F, kRounded = 1.5F;
  if (now == 0 || !(n.p->THR_SLEW > 0)) return true;
  const float most = n.p->THR_SLEW * kFull * static_cast<float>(n.dt_us) * 1e-6F + kRounded;
  return std::abs(static_cast<float>(now) - static_cast<float>(before)) <= most;
}

/// ArduPilot Rover's mode numbers, as in heartbeats.
constexpr std::uint8_t mode_of(State state) {
  if (state == State::kManual) return app::mode::kManual;
  if (state == State::kAuto) return app::mode::kAuto;
  if (state == State::kGuided) return app::mode::kGuided;
  if (state == State::kLoiter) return app::mode::kLoiter;
  if (state == State::kReturn) return app::mode::kReturn;
  return core::follows(state) ? app::mode::kFormation : app::mode::kHold;
}

/// A state became known, or a newer one arrived. An age that stays 0 means a stamp in the future.
inline bool moved(const std::optional<double>& before_s, const std::optional<double>& now_s,
                  const Moment& n) {
  constexpr double kRounded_s = 1e-4;
  if (!now_s || (before_s && *now_s == 0 && *before_s == 0)) return false;
  return !before_s || *now_s < *before_s + static_cast<double>(n.dt_us) * 1e-6 - kRounded_s;
}

inline constexpr std::array kAll{
#define POLICY(group, name, condition) \
  Rule{group, name,                    \
       []([[maybe_unused]] const Seen& b, const Moment& n) -> bool { return condition; }},
#include "policies/rules.def"
#undef POLICY
};
static_assert(kAll.size() >= 60);

}  // namespace rules

inline constexpr auto& kRules = rules::kAll;

}  // namespace flotilla::policies
