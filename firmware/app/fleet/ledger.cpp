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
  replaced_epoch_ = current_.epoch;
  replaced_digest_ = current_.digest;
  current_ = *next_;
  next_.reset();
}

bool FleetLedger::replaces(std::uint16_t epoch, std::uint16_t digest) const {
  if (epoch == 0) return false;
  if (next_) return epoch == current_.epoch && digest == current_.digest;
  return epoch == replaced_epoch_ && digest == replaced_digest_;
}

}  // namespace flotilla::app
