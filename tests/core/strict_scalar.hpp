// SPDX-License-Identifier: MIT
// A scalar that can do only what core's contract with its scalars promises: made explicitly from an
// int or a double, a closed list of operations, nothing implicit. It notes the values it takes.
#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>

namespace flotilla::testing {

/// Range of all values since the last reset.
struct Range {
  double least = std::numeric_limits<double>::infinity();
  double greatest = -std::numeric_limits<double>::infinity();
  double magnitude = 0;
  bool saw_nan = false;
};

class Strict {
 public:
  static inline Range seen{};

  constexpr Strict() = default;
  template <class T>
    requires std::same_as<T, int> || std::same_as<T, double>
  explicit Strict(T value) : value_(static_cast<double>(value)) {
    seen.least = std::min(seen.least, value_);
    seen.greatest = std::max(seen.greatest, value_);
    seen.magnitude = std::max(seen.magnitude, std::abs(value_));
    seen.saw_nan = seen.saw_nan || std::isnan(value_);
  }

  /// For tests, never for core.
  double value() const { return value_; }

  friend Strict operator-(Strict a) { return Strict(-a.value_); }
  friend Strict operator+(Strict a, Strict b) { return Strict(a.value_ + b.value_); }
  friend Strict operator-(Strict a, Strict b) { return Strict(a.value_ - b.value_); }
  friend Strict operator*(Strict a, Strict b) { return Strict(a.value_ * b.value_); }
  friend Strict operator/(Strict a, Strict b) { return Strict(a.value_ / b.value_); }
  friend bool operator<(Strict a, Strict b) { return a.value_ < b.value_; }
  friend bool operator<=(Strict a, Strict b) { return a.value_ <= b.value_; }
  friend bool operator>(Strict a, Strict b) { return a.value_ > b.value_; }
  friend bool operator>=(Strict a, Strict b) { return a.value_ >= b.value_; }

  friend Strict abs(Strict a) { return Strict(std::abs(a.value_)); }
  friend Strict atan(Strict a) { return Strict(std::atan(a.value_)); }
  friend Strict atan2(Strict a, Strict b) { return Strict(std::atan2(a.value_, b.value_)); }
  friend Strict ceil(Strict a) { return Strict(std::ceil(a.value_)); }
  friend Strict cos(Strict a) { return Strict(std::cos(a.value_)); }
  friend Strict exp(Strict a) { return Strict(std::exp(a.value_)); }
  friend Strict sin(Strict a) { return Strict(std::sin(a.value_)); }
  friend Strict sqrt(Strict a) { return Strict(std::sqrt(a.value_)); }
  friend Strict tanh(Strict a) { return Strict(std::tanh(a.value_)); }

 private:
  double value_ = 0;
};

inline double number_of(Strict x) { return x.value(); }

}  // namespace flotilla::testing
