// SPDX-License-Identifier: MIT
// Sends texts to all operators, and limits how often each kind of text is repeated.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string_view>

#include "app/operator/mavlink_links.hpp"
#include "app/schedule.hpp"
#include "core/supervisor.hpp"

namespace flotilla::app {

/// Kinds of texts that are repeated only after an interval; each kind has its own.
enum class TextKind : std::uint8_t {
  kArmRefused,
  kRefused,
  kParameterRefused,
  kStopPressed,
  kDoubled,  ///< another sender uses the boat's ids
  kIgnored,
  kSigning,
};

class StatusTexts {
 public:
  /// Sends on `links`, which must outlive this.
  explicit StatusTexts(MavlinkLinks& links) : links_(links) {}

  /// Sends a text, in chunks of 50 characters if it is longer.
  void send(std::uint8_t severity, std::initializer_list<std::string_view> parts,
            link::Counters& counters);

  /// Sends a warning for each unmet condition, as many as leave room for the heartbeat; the others
  /// follow once these are remedied.
  void send_complaints(std::string_view what, core::Conditions unmet, link::Counters& counters);

  /// Whether a text of this kind may be sent now; counts it as sent.
  bool take_if_due(TextKind kind, std::int64_t now_us) {
    return due_[static_cast<std::size_t>(kind)].take_if_due(now_us);
  }

 private:
  static constexpr std::int64_t kAnswer_us = 500'000, kAlarm_us = 10'000'000;

  MavlinkLinks& links_;
  std::uint16_t id_ = 0;  ///< of the last text in chunks
  std::array<Schedule, 7> due_{Schedule(kAnswer_us), Schedule(kAnswer_us), Schedule(kAnswer_us),
                               Schedule(kAlarm_us),  Schedule(kAlarm_us),  Schedule(kAlarm_us),
                               Schedule(kAlarm_us)};
};

}  // namespace flotilla::app
