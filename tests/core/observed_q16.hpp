// SPDX-License-Identifier: MIT
// A Q16 that records the values on each line of the source. The compiler includes it before
// everything else (-include), so the sources and the shipped Q16 stay unchanged.
//
// Records, for each line, the largest magnitude of any operand or result of Q16's operations.
#pragma once

#if __has_include("core/scalar/fixed.hpp")

#include <algorithm>
#include <source_location>
#include <string>
#include <type_traits>
#include <unordered_map>

#define Q16 PlainQ16
#include "core/scalar/fixed.hpp"
#undef Q16

namespace flotilla::core {

using Where = std::source_location;

/// Largest |raw| by line; its key: address of the file's name, then the line's number.
inline std::unordered_map<std::uint64_t, std::uint32_t> q16_seen;

template <class... Raw>
std::int32_t noted(const Where& where, std::int32_t result, Raw... operands) {
  const auto file = reinterpret_cast<std::uint64_t>(where.file_name());
  std::uint32_t& most = q16_seen[file << 16U | where.line()];
  most = std::max({most, fixed::magnitude(result), fixed::magnitude(operands)...});
  return result;
}

class Q16 {
 public:
  constexpr Q16() = default;
  template <std::integral T>
  constexpr explicit Q16(T whole) : x_(whole) {}
  consteval explicit Q16(double literal) : x_(literal) {}

  static constexpr Q16 of_raw(std::int32_t raw) { return Q16(PlainQ16::of_raw(raw), 0); }
  constexpr std::int32_t raw() const { return x_.raw(); }
  constexpr PlainQ16 plain() const { return x_; }
  static constexpr std::int64_t halved(std::int64_t x, int n) { return PlainQ16::halved(x, n); }
  static constexpr std::int32_t saturated(std::int64_t raw) { return PlainQ16::saturated(raw); }
  static constexpr Q16 rounded(std::int64_t x) { return of_raw(PlainQ16::rounded(x).raw()); }

  friend constexpr bool operator==(Q16 a, Q16 b) = default;
  friend constexpr auto operator<=>(Q16 a, Q16 b) = default;

  /// An operator's first operand. The conversion happens on the line that has the operator.
  struct First {
    PlainQ16 x;
    Where where;
    constexpr First(Q16 a, Where w = Where::current()) : x(a.x_), where(w) {}  // NOLINT: implicit
  };

  friend Q16 operator-(First a) { return of_raw(noted(a.where, (-a.x).raw(), a.x.raw())); }
  friend constexpr Q16 operator+(First a, Q16 b) { return note(a, b, a.x + b.x_); }
  friend constexpr Q16 operator-(First a, Q16 b) { return note(a, b, a.x - b.x_); }
  friend constexpr Q16 operator*(First a, Q16 b) { return note(a, b, a.x * b.x_); }
  friend constexpr Q16 operator/(First a, Q16 b) { return note(a, b, a.x / b.x_); }

 private:
  constexpr Q16(PlainQ16 x, int) : x_(x) {}
  static constexpr Q16 note(const First& a, Q16 b, PlainQ16 result) {
    if (std::is_constant_evaluated()) return of_raw(result.raw());
    return of_raw(noted(a.where, result.raw(), a.x.raw(), b.raw()));
  }

  PlainQ16 x_;
};

#define FLOTILLA_NOTED(name)                                          \
  inline Q16 name(Q16 a, Where where = Where::current()) {            \
    return Q16::of_raw(noted(where, name(a.plain()).raw(), a.raw())); \
  }
FLOTILLA_NOTED(sin)
FLOTILLA_NOTED(cos)
FLOTILLA_NOTED(atan)
FLOTILLA_NOTED(tanh)
FLOTILLA_NOTED(exp)
FLOTILLA_NOTED(sqrt)
FLOTILLA_NOTED(abs)
FLOTILLA_NOTED(ceil)
#undef FLOTILLA_NOTED

inline SinCos<Q16> sin_cos(Q16 x, Where where = Where::current()) {
  return {sin(x, where), cos(x, where)};
}
inline Q16 sum_of_products(Q16 a, Q16 b, Q16 c, Q16 d, Where where = Where::current()) {
  const PlainQ16 result = sum_of_products(a.plain(), b.plain(), c.plain(), d.plain());
  return Q16::of_raw(noted(where, result.raw(), a.raw(), b.raw(), c.raw(), d.raw()));
}
inline Q16 difference_of_products(Q16 a, Q16 b, Q16 c, Q16 d, Where where = Where::current()) {
  const PlainQ16 result = difference_of_products(a.plain(), b.plain(), c.plain(), d.plain());
  return Q16::of_raw(noted(where, result.raw(), a.raw(), b.raw(), c.raw(), d.raw()));
}
inline Q16 atan2(Q16 y, Q16 x, Where where = Where::current()) {
  return Q16::of_raw(noted(where, atan2(y.plain(), x.plain()).raw(), y.raw(), x.raw()));
}
inline Q16 hypot(Q16 x, Q16 y, Where where = Where::current()) {
  return Q16::of_raw(noted(where, hypot(x.plain(), y.plain()).raw(), x.raw(), y.raw()));
}
inline Q16 hypot(Q16 x, Q16 y, Q16 z, Where where = Where::current()) {
  return hypot(hypot(x, y, where), z, where);
}
inline Q16 scaled(Q16 a, Q16 b, Q16 c, Where where = Where::current()) {
  const PlainQ16 result = scaled(a.plain(), b.plain(), c.plain());
  return Q16::of_raw(noted(where, result.raw(), a.raw(), b.raw(), c.raw()));
}

}  // namespace flotilla::core

/// Lines `FILE:LINE RAW` of what was seen since the last call; the text stays until the next one.
extern "C" [[gnu::used, gnu::visibility("default")]] inline const char* q16_take_seen() {
  static std::string text;
  text.clear();
  for (const auto& [key, most] : flotilla::core::q16_seen) {
    text += reinterpret_cast<const char*>(key >> 16U);
    text += ':' + std::to_string(key & 0xFFFFU) + ' ' + std::to_string(most) + '\n';
  }
  flotilla::core::q16_seen.clear();
  return text.c_str();
}

#endif
