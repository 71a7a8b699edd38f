// SPDX-License-Identifier: MIT
// Detects overflow and NaN in the law's arithmetic.
#pragma once

#include <utility>

#include "core/scalar/overflow.hpp"

namespace flotilla::app {

/// All boats of a thread share one overflow flag, so each call of a boat clears it first and
/// collects it at the end.
template <class S>
class ScalarRange {
 public:
  static void clear() { core::take_overflow<S>(); }
  void collect() { overflow_ = core::take_overflow<S>() || overflow_; }

  /// Treats NaN like an overflow.
  void collect(S number) { overflow_ = !(number == number) || overflow_; }

  /// Call when all parameters have been converted, and nothing else since the last collect().
  void judge_parameters() {
    fits_ = !core::take_overflow<S>();
    is_kept_ = is_kept_ && fits_;
  }

  /// Call once a tick: judges everything computed since the last call.
  void judge() { is_kept_ = fits_ && !std::exchange(overflow_, false); }

  /// The result of the last judge().
  bool is_kept() const { return is_kept_; }

  /// Whether an overflow was collected since the last judge().
  bool has_overflowed() const { return overflow_; }

 private:
  bool fits_ = true;  // the scalar can hold all parameters
  bool overflow_ = false;
  bool is_kept_ = true;
};

}  // namespace flotilla::app
