// SPDX-License-Identifier: MIT
// Filters one vessel's states by their stamps: repeated, late, or from a restarted clock.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <optional>

#include "app/navigation/clock_offset.hpp"

namespace flotilla::app {

class StampFilter {
 public:
  enum class Verdict : std::uint8_t {
    kNext,       ///< newer than the last one, or the first
    kSet,        ///< newer, but over 1 s off our elapsed time: sender's clock was set
    kWrapped,    ///< over 10 min too new: a restarted 32-bit clock appears to leap ahead
    kLate,       ///< not newer
    kRestarted,  ///< not newer, but advancing: sender's clock restarted or was set back
  };

  /// one_link: no state can be overtaken on another link, so stamps that go back and then advance
  /// come from a clock that was set back or restarted.
  Verdict judge(std::int64_t stamp_us, std::int64_t now_us, bool one_link = false) const {
    if (!last_us_) return Verdict::kNext;
    if (stamp_us <= *last_us_) {
      const bool restarted = silent(now_us) && advances(stamp_us) && stamp_us != *last_us_ &&
                             (one_link || is_restart(stamp_us, *last_us_, now_us - arrived_us_));
      return restarted ? Verdict::kRestarted : Verdict::kLate;
    }
    const std::int64_t off_us = stamp_us - *last_us_ - (now_us - arrived_us_);
    if (off_us > kLeap_us) return Verdict::kWrapped;
    return std::abs(off_us) > kSilent_us ? Verdict::kSet : Verdict::kNext;
  }

  /// Notes a late state that was not used.
  void refuse(std::int64_t stamp_us) {
    refused_in_a_row_ = advances(stamp_us) ? refused_in_a_row_ + 1 : 1;
    refused_us_ = stamp_us;
  }

  /// Notes that a state was used, whose heading is older by heading_older_us.
  void accept(std::int64_t stamp_us, std::int64_t heading_older_us, std::int64_t now_us) {
    forget();
    last_us_ = stamp_us;
    heading_older_us_ = heading_older_us;
    arrived_us_ = now_us;
  }

  /// The next stamp is not compared with those before it.
  void forget() {
    last_us_.reset();
    refused_us_.reset();
    refused_in_a_row_ = 0;
  }

  /// Stamp of the last state accepted; nothing if the next one does not continue it.
  const std::optional<std::int64_t>& last_us() const { return last_us_; }
  std::int64_t heading_older_us() const { return heading_older_us_; }
  std::int64_t arrived_us() const { return arrived_us_; }

  /// Nothing has been accepted for 1 s.
  bool silent(std::int64_t now_us) const { return now_us - arrived_us_ > kSilent_us; }

  /// States come in order, but late: the clock was set back, or one stamp ran ahead.
  bool regularly_late() const { return refused_in_a_row_ >= 3; }

 private:
  static constexpr std::int64_t kSilent_us = 1'000'000, kLeap_us = 600'000'000;

  bool advances(std::int64_t stamp_us) const { return refused_us_ && stamp_us > *refused_us_; }

  std::optional<std::int64_t> last_us_, refused_us_;
  std::int64_t heading_older_us_ = 0, arrived_us_ = 0;
  int refused_in_a_row_ = 0;
};

}  // namespace flotilla::app
