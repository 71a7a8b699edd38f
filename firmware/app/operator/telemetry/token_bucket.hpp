// SPDX-License-Identifier: MIT
// Token bucket of a slow link: shares its rate so that nothing starves.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>

namespace flotilla::app {

/// Three fifths of the rate are reserved for the state that followers need, two for everything
/// else; each may use what the other leaves. Credit and debt are limited to half a second's worth.
class TokenBucket {
 public:
  /// Bytes per second; 0: no limit.
  void limit(std::uint32_t bytes_per_s) { rate_Bps_ = bytes_per_s; }
  std::uint32_t limit() const { return rate_Bps_; }

  void earn(std::int64_t dt_us) {
    if (rate_Bps_ == 0 && state_ == 0 && rest_ == 0) return;
    const std::int64_t earned = std::int64_t{rate_Bps_} * std::min(dt_us, kSecond_us);
    const std::int64_t over = save(state_, earned * 3 / 5, most() * 3 / 5);
    const std::int64_t left = save(rest_, earned * 2 / 5 + over, most() * 2 / 5);
    save(state_, left, most() * 3 / 5);
  }

  bool for_state() const { return rate_Bps_ == 0 || state_ > 0; }
  bool for_rest() const { return rate_Bps_ == 0 || rest_ > 0; }
  bool rest_is_full() const { return rest_ >= most() * 2 / 5; }

  void spend_on_state(std::size_t bytes) { spend(state_, bytes); }
  void spend_on_rest(std::size_t bytes) { spend(rest_, bytes); }

 private:
  static constexpr std::int64_t kSecond_us = 1'000'000;

  std::int64_t most() const { return std::int64_t{rate_Bps_} * kSecond_us / 2; }

  /// Returns the overflow of the bucket.
  static std::int64_t save(std::int64_t& bucket, std::int64_t earned, std::int64_t most) {
    const std::int64_t all = bucket + earned;
    bucket = std::min(all, most);
    return all - bucket;
  }

  void spend(std::int64_t& bucket, std::size_t bytes) const {
    bucket = std::max(bucket - static_cast<std::int64_t>(bytes) * kSecond_us, -most());
  }

  std::uint32_t rate_Bps_ = 0;
  std::int64_t state_ = 0, rest_ = 0;  // bytes × 10⁶
};

}  // namespace flotilla::app
