// SPDX-License-Identifier: MIT
// Sentences for the operator that contain figures, as pure functions of the boat's findings. The
// others are in text.hpp, or where they are sent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "app/estimation/model_monitor.hpp"
#include "app/plan/voyage.hpp"
#include "app/sentence.hpp"
#include "core/station.hpp"

namespace flotilla::app {

/// "slot needs 2.13 m/s, LAW_U_MAX is 1.5"; rounded up, so that the figure exceeds the limit.
Sentence slot_needs(double needed, std::string_view limit_is, float limit);

/// Why the boat does not keep its station. loss: not kNo; off_m: distance from the slot;
/// yaw_rate: its absolute value, rad/s.
Sentence sentence_of(core::StationLoss loss, double off_m, double yaw_rate,
                     const Parameters& derived);

/// "Port 12 % weak since 10:31: THR_BALANCE 0.06", in UTC; or "for 7 min" if unix_us, the time of
/// day at now_us, is 0 (unknown).
Sentence sentence_of(const ModelMonitor::Finding& finding, float balance, std::int64_t now_us,
                     std::int64_t unix_us);

Sentence sentence_of(const VoyageNews& news);

/// late: the boat that the fleet waits for; nothing: the fleet no longer waits.
Sentence waiting_for(std::optional<std::uint8_t> late);

Sentence unit_is_late(double latency_s);
Sentence slot_is_taken(std::uint8_t by);
Sentence too_deep(std::size_t depth, float certified);

/// links: a bit mask; the sentence names the first.
Sentence link_is_closed(std::uint8_t links);

}  // namespace flotilla::app
