// SPDX-License-Identifier: MIT
#include "app/fleet/ledger.hpp"

#include <algorithm>

namespace flotilla::app {

bool FleetLedger::take(const FleetTable& table, std::int64_t valid_us, std::int64_t now_us) {
  const std::int64_t from_us = table.stop ? now_us : valid_us;
  if (is_newer(table.epoch, table.digest, newest())) {
    next_ = table;
    valid_us_ = from_us;
    return true;
  }
  const bool same = next_ && table.epoch == next_->epoch && table.digest == next_->digest;
  if (same) valid_us_ = std::min(valid_us_, from_us);
  return false;
}

void FleetLedger::forward(std::int64_t now_us) {
  if (!is_due(now_us)) return;
  current_ = *next_;
  next_.reset();
}

std::uint16_t FleetLedger::in_ms(std::int64_t now_us) const {
  if (!next_) return 0;
  constexpr std::int64_t kMost_ms = 65'535;
  return static_cast<std::uint16_t>(
      std::clamp<std::int64_t>((valid_us_ - now_us) / 1000, 0, kMost_ms));
}

}  // namespace flotilla::app
