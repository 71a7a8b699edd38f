// SPDX-License-Identifier: MIT
// Keeps the headings of ATTITUDE, to be joined with positions.
#pragma once

#include <cstdint>

#include "app/convert/convert.hpp"

namespace flotilla::app {

/// Keeps one heading of the component in use, and one of another component, which may replace it
/// once its position arrives too.
template <class S>
class Headings {
 public:
  struct Heading {
    std::uint8_t component = 0;
    convert::HeadingSample<S> sample{};
    std::int64_t arrived_us = 0;
  };

  /// An older heading cannot be extrapolated to the time of a position.
  static constexpr std::int64_t kUsable_us = 300'000;

  /// The component's last heading; nullptr if it has sent none.
  const Heading* of(std::uint8_t component, bool in_use) const {
    const Heading& heading = in_use ? in_use_ : other_;
    return heading.component == component ? &heading : nullptr;
  }

  /// From now on the component of this heading is in use.
  void use(const Heading& heading) { in_use_ = heading; }

  enum class Verdict : std::uint8_t {
    kTaken,
    kLate,   ///< its stamp is not newer than the last one
    kLeapt,  ///< implausibly new: perhaps from another vessel; would make later stamps look old
  };

  /// silent: the vessel may have rebooted, so an old stamp is accepted.
  Verdict take(convert::HeadingSample<S> sample, std::uint8_t component, bool in_use, bool silent,
               std::int64_t now_us) {
    Heading& last = in_use ? in_use_ : other_;
    if (last.component == component) {
      sample.stamp_us = convert::unwrapped_us(sample.stamp_us, last.sample.stamp_us);
      const std::int64_t later_us = sample.stamp_us - last.sample.stamp_us;
      const std::int64_t since_us = now_us - last.arrived_us;
      if (later_us <= 0 && !silent) return Verdict::kLate;
      if (since_us < kUsable_us && later_us > since_us + kLeap_us) return Verdict::kLeapt;
    }
    last = {component, sample, now_us};
    return Verdict::kTaken;
  }

 private:
  static constexpr std::int64_t kLeap_us = 1'000'000;

  Heading in_use_, other_;
};

}  // namespace flotilla::app
