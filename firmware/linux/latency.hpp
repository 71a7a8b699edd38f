// SPDX-License-Identifier: MIT
// A histogram of latencies in microseconds that never allocates.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

namespace flotilla::target {

class Latency {
 public:
  void add(std::int64_t us) {
    const std::int64_t bin = std::clamp<std::int64_t>(us, 0, kBins - 1);
    ++bins_[static_cast<std::size_t>(bin)];
    ++count_;
    greatest_us_ = std::max(greatest_us_, us);
  }

  std::uint64_t count() const { return count_; }
  std::int64_t greatest_us() const { return greatest_us_; }

  /// The least time that a share (0 … 1) of all samples did not exceed; saturates at 20 ms.
  std::int64_t percentile_us(double share) const {
    std::uint64_t seen = 0;
    for (std::size_t us = 0; us < bins_.size(); ++us) {
      seen += bins_[us];
      if (static_cast<double>(seen) >= share * static_cast<double>(count_) && seen > 0) {
        return static_cast<std::int64_t>(us);
      }
    }
    return kBins - 1;
  }

 private:
  static constexpr std::int64_t kBins = 20'001;
  std::array<std::uint32_t, kBins> bins_{};
  std::uint64_t count_ = 0;
  std::int64_t greatest_us_ = 0;
};

}  // namespace flotilla::target
