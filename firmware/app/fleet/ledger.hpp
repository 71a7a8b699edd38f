// SPDX-License-Identifier: MIT
// The tables that a boat holds: the one in force, and the next.
#pragma once

#include <cstdint>
#include <optional>

#include "app/fleet/table.hpp"

namespace flotilla::app {

/// The newest table wins: the greater epoch, then the greater digest, so that all boats choose the
/// same one. Times are by the boat's own clock: a message carries the time until, or since, the
/// table comes into force, and a boat that relays it updates that time.
class FleetLedger {
 public:
  /// Takes a valid table that comes into force at `valid_us`, or at once if it stops all boats.
  /// False if it is not newer than the one held. For the same table the earliest time counts,
  /// because radios only delay.
  [[nodiscard]] bool take(const FleetTable& table, std::int64_t valid_us, std::int64_t now_us);

  /// A table is due; forward() activates it.
  bool is_due(std::int64_t now_us) const { return next_ && now_us >= valid_us_; }
  void forward(std::int64_t now_us);

  /// In force; nullptr before the first one.
  const FleetTable* current() const { return current_.epoch != 0 ? &current_ : nullptr; }

  /// In force or next; epoch 0 if there is none.
  const FleetTable& newest() const { return next_ ? *next_ : current_; }

  /// When newest() comes or came into force.
  std::int64_t valid_us() const { return valid_us_; }

  /// Whether newest() replaces the table with this epoch and digest.
  bool replaces(std::uint16_t epoch, std::uint16_t digest) const;

 private:
  FleetTable current_;
  std::optional<FleetTable> next_;
  std::int64_t valid_us_ = 0;                               // of newest()
  std::uint16_t replaced_epoch_ = 0, replaced_digest_ = 0;  // by current_
};

/// Whether a table with this epoch and digest replaces that one.
constexpr bool is_newer(std::uint16_t epoch, std::uint16_t digest, const FleetTable& than) {
  return epoch != than.epoch ? epoch > than.epoch : digest > than.digest;
}

}  // namespace flotilla::app
