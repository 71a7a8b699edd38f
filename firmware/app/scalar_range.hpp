// SPDX-License-Identifier: MIT
// Whether the law's numbers stay within its scalar's range.
#pragma once

#include <utility>

#include "core/scalar/overflow.hpp"

namespace flotilla::app {

/// The flag of an overflow is shared by all boats of a thread, so each call of the boat clears it
/// first and collects it at its end.
template <class S>
class ScalarRange {
 public:
  static void clear() { core::take_overflow<S>(); }
  void collect() { overflow_ = core::take_overflow<S>() || overflow_; }

  /// Call when all parameters have been converted, and nothing else since the last collect().
  void judge_parameters() {
    fits_ = !core::take_overflow<S>();
    is_kept_ = is_kept_ && fits_;
  }

  /// Once a tick: judges all that was computed since the last one.
  void judge() { is_kept_ = fits_ && !std::exchange(overflow_, false); }

  /// As last judged.
  bool is_kept() const { return is_kept_; }

  /// An overflow was collected since then.
  bool has_overflowed() const { return overflow_; }

 private:
  bool fits_ = true;  // it holds all parameters
  bool overflow_ = false;
  bool is_kept_ = true;
};

}  // namespace flotilla::app
