// SPDX-License-Identifier: MIT
#include "app/convert/convert_reference.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "app/convert/portable.hpp"

namespace flotilla::app::convert {
namespace {

constexpr int kParts = 1024, kHeadingParts = 8192, kTurnParts = 4096;
constexpr int kSurgeSteps = 4, kTurnSteps = 8;  // parts per unit of a change in FORMATION_FUTURE
constexpr int kMetresShift = 22;                // from Metres' 2⁻³² m to 2⁻¹⁰ m
constexpr std::int64_t kFarthest = std::int64_t{1'000'000} * kParts;
constexpr std::int32_t kFarthestSlot = 100'000 * kParts;

Metres metres_of(std::int32_t parts) {
  return Metres::of_raw(std::int64_t{parts} * (std::int64_t{1} << kMetresShift));
}

std::int64_t parts_of(Metres x) {
  const std::int64_t half = std::int64_t{1} << (kMetresShift - 1);
  return (x.raw() + half) >> kMetresShift;
}

/// The nearest whole part; nothing beyond 16 bits.
template <class S>
std::optional<std::int16_t> parts_of(S x, int parts) {
  const S most = S(32767) / S(parts);
  if (!(-most < x && x < most)) return std::nullopt;
  const S scaled = x * S(parts);
  return static_cast<std::int16_t>(whole(scaled < S(0) ? scaled - S(0.5) : scaled + S(0.5)));
}

/// Exact, because `parts` is a power of two.
template <class S, int parts>
S of_parts(std::int16_t x) {
  constexpr S kPart = S(1) / S(parts);
  return S(int{x}) * kPart;
}

template <class S, int turn_parts>
core::Nu<S> nu_of(const std::array<std::int16_t, 3>& x) {
  return {of_parts<S, kParts>(x[0]), of_parts<S, kParts>(x[1]), of_parts<S, turn_parts>(x[2])};
}

template <class S>
std::optional<std::array<std::int16_t, 3>> wire_of(const core::Nu<S>& nu, int turn_parts) {
  const auto u = parts_of(nu.u, kParts), v = parts_of(nu.v, kParts), r = parts_of(nu.r, turn_parts);
  if (!u || !v || !r) return std::nullopt;
  return std::array{*u, *v, *r};
}

using Changes = std::array<std::int8_t, core::kFutureSamples>;

/// False if one is beyond `most` parts.
template <class S, int parts>
bool read_samples(std::int16_t first, const Changes& changes, int step, int most, auto& out) {
  int sum = first;
  for (std::size_t k = 0; k < out.size(); ++k) {
    if (k > 0) sum += step * changes[k - 1];
    if (std::abs(sum) > most) return false;
    out[k] = of_parts<S, parts>(static_cast<std::int16_t>(sum));
  }
  return true;
}

/// The rounding error of each change is carried into the next one.
template <class S>
bool write_samples(const auto& samples, int parts, int step, std::int16_t& first,
                   Changes& changes) {
  const auto begin = parts_of(samples[0], parts);
  if (!begin) return false;
  first = *begin;
  int sum = first;
  for (std::size_t k = 0; k < changes.size(); ++k) {
    const auto sample = parts_of(samples[k + 1], parts);
    if (!sample) return false;
    const int off = *sample - sum, half = off < 0 ? -step / 2 : step / 2;
    const int change = std::clamp((off + half) / step, -127, 127);
    changes[k] = static_cast<std::int8_t>(change);
    sum += step * change;
  }
  return true;
}

}  // namespace

WireOffset wire_offset_of(float a_m, float b_m) {
  const auto parts = [](float m) {
    return static_cast<std::int32_t>(portable::nearest(double{m} * kParts));
  };
  return {parts(a_m), parts(b_m)};
}

float length_m(const WireOffset& offset) {
  return static_cast<float>(portable::hypot(offset[0], offset[1]) / kParts);
}

std::optional<WireOffset> sum_of(const WireOffset& a, const WireOffset& b) {
  WireOffset sum{};
  for (std::size_t i = 0; i < sum.size(); ++i) {
    const std::int64_t parts = std::int64_t{a[i]} + b[i];
    if (std::abs(parts) > kFarthestSlot) return std::nullopt;
    sum[i] = static_cast<std::int32_t>(parts);
  }
  return sum;
}

template <class S>
core::Vec2<S> offset_of(const WireOffset& offset) {
  return {scalar<S>(metres_of(offset[0])), scalar<S>(metres_of(offset[1]))};
}

template <class S>
std::optional<RootState<S>> root_state_of(const link::FormationReference& m,
                                          std::int32_t altitude_mm) {
  const link::GpsGlobalOrigin origin{m.latitude, m.longitude, altitude_mm, 0};
  const bool turns_once = std::abs(int{m.heading}) <= 4 * kHeadingParts;
  if (!is_valid(origin) || !turns_once || std::abs(std::int64_t{m.north}) > kFarthest ||
      std::abs(std::int64_t{m.east}) > kFarthest) {
    return std::nullopt;
  }
  return RootState<S>{{metres_of(m.north), metres_of(m.east), origin},
                      {of_parts<S, kHeadingParts>(m.heading), nu_of<S, kTurnParts>(m.nu),
                       nu_of<S, kParts>(m.nu_dot), of_parts<S, kParts>(m.r_ddot)}};
}

template <class S>
std::optional<link::FormationReference> reference_of(const RootState<S>& root) {
  const auto& [psi, nu, nu_dot, r_ddot] = root.motion;
  const auto heading = parts_of(core::wrap_pi(psi), kHeadingParts);
  const auto velocity = wire_of(nu, kTurnParts), rates = wire_of(nu_dot, kParts);
  const auto jerk = parts_of(r_ddot, kParts);
  const std::int64_t north = parts_of(root.position.north_m);
  const std::int64_t east = parts_of(root.position.east_m);
  if (!heading || !velocity || !rates || !jerk || std::abs(north) > kFarthest ||
      std::abs(east) > kFarthest) {
    return std::nullopt;
  }
  const link::GpsGlobalOrigin& origin = root.position.origin;
  link::FormationReference out{};
  out.latitude = origin.latitude;
  out.longitude = origin.longitude;
  out.north = static_cast<std::int32_t>(north);
  out.east = static_cast<std::int32_t>(east);
  out.heading = *heading;
  out.nu = *velocity;
  out.nu_dot = *rates;
  out.r_ddot = *jerk;
  return out;
}

template <class S>
std::optional<core::Future<S>> future_of(const link::FormationFuture& m) {
  constexpr int kFastest = 20 * kParts, kTurnsFastest = 4 * kTurnParts;
  core::Future<S> out;
  if (!read_samples<S, kParts>(m.u, m.u_change, kSurgeSteps, kFastest, out.u) ||
      !read_samples<S, kTurnParts>(m.r, m.r_change, kTurnSteps, kTurnsFastest, out.r)) {
    return std::nullopt;
  }
  return out;
}

template <class S>
std::optional<link::FormationFuture> message_of(const core::Future<S>& future) {
  link::FormationFuture out{};
  if (!write_samples<S>(future.u, kParts, kSurgeSteps, out.u, out.u_change) ||
      !write_samples<S>(future.r, kTurnParts, kTurnSteps, out.r, out.r_change)) {
    return std::nullopt;
  }
  return out;
}

#define FLOTILLA_INSTANTIATE(S)                                                          \
  template core::Vec2<S> offset_of<S>(const WireOffset&);                                \
  template std::optional<RootState<S>> root_state_of<S>(const link::FormationReference&, \
                                                        std::int32_t);                   \
  template std::optional<link::FormationReference> reference_of<S>(const RootState<S>&); \
  template std::optional<core::Future<S>> future_of<S>(const link::FormationFuture&);    \
  template std::optional<link::FormationFuture> message_of<S>(const core::Future<S>&);
FLOTILLA_INSTANTIATE(float)
FLOTILLA_INSTANTIATE(double)
FLOTILLA_INSTANTIATE(core::Q16)
#undef FLOTILLA_INSTANTIATE

}  // namespace flotilla::app::convert
