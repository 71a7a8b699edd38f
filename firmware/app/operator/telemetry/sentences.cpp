// SPDX-License-Identifier: MIT
#include "app/operator/telemetry/sentences.hpp"

#include <bit>

#include "app/convert/portable.hpp"

namespace flotilla::app {
namespace {

float hundredths(std::int64_t n) { return static_cast<float>(n) / 100; }

/// Rounds a number under 1000 to the nearest 1/n.
float to_nearest(float x, int n) {
  const float scaled = static_cast<float>(n) * x;
  return static_cast<float>(static_cast<int>(scaled + (x < 0 ? -0.5F : 0.5F))) /
         static_cast<float>(n);
}

void put_since(Sentence& out, std::int64_t ago_us, std::int64_t unix_us) {
  constexpr std::int64_t kMinute_us = 60'000'000;
  constexpr std::uint32_t kHour = 60, kDay = 24;
  if (unix_us <= 0) {
    const std::int64_t minutes = (ago_us + kMinute_us / 2) / kMinute_us;
    out << " for " << static_cast<float>(minutes < 1 ? 1 : minutes) << " min";
    return;
  }
  const auto minutes = static_cast<std::uint32_t>((unix_us - ago_us) / kMinute_us);
  const std::uint32_t hour = minutes / kHour % kDay, minute = minutes % kHour;
  out << (hour < 10 ? " since 0" : " since ") << static_cast<float>(hour)
      << (minute < 10 ? ":0" : ":") << static_cast<float>(minute);
}

}  // namespace

Sentence slot_needs(double needed, std::string_view limit_is, float limit) {
  Sentence out;
  out << "slot needs " << hundredths(portable::ceil(100 * needed)) << limit_is << limit;
  return out;
}

Sentence sentence_of(core::StationLoss loss, double off_m, double yaw_rate,
                     const Parameters& derived) {
  Sentence why;
  if (loss == core::StationLoss::kSpins) {
    why << "boat spins: " << hundredths(portable::nearest(100 * yaw_rate))
        << " rad/s, LAW_R_MAX is " << derived.LAW_R_MAX;
    return why;
  }
  const float off = hundredths(10 * portable::nearest(10 * off_m));
  if (loss == core::StationLoss::kLeft) {
    why << "boat left its slot: " << off << " m off, FS_SLOT_M is " << derived.FS_SLOT_M;
  } else {
    why << "boat does not approach its slot: " << off << " m off";
  }
  return why;
}

Sentence sentence_of(const ModelMonitor::Finding& finding, float balance, std::int64_t now_us,
                     std::int64_t unix_us) {
  using enum ModelMonitor::Number;
  const auto& [number, value, since_us] = finding;
  Sentence text;
  if (number == kBalance) {
    const float change = value - balance;
    const float size = change < 0 ? -change : change;
    const float percent = to_nearest(200 * size / (1 + size), 1);
    text << (change < 0 ? "Starboard " : "Port ") << percent << " % weak";
  } else {
    text << (number == kDrag ? "Drag " : "Yaw damping ") << to_nearest(value, 10) << " x "
         << (number == kDrag ? "VES_D11" : "VES_D33");
  }
  put_since(text, now_us - since_us, unix_us);
  if (number == kBalance) {
    text << ": THR_BALANCE " << to_nearest(value, 100);
  } else {
    text << ": identify the hull";
  }
  return text;
}

Sentence sentence_of(const VoyageNews& news) {
  using enum VoyageNews::Kind;
  const auto count = static_cast<float>(kVoyageSteps.size());
  Sentence text;
  text << "Voyage: ";
  if (news.kind == kOver) {
    text << "over, " << static_cast<float>(news.step) << " of " << count << " steps complete";
  } else if (news.kind == kLost) {
    text << "the boat did not return to its area";
  } else {
    text << "step " << static_cast<float>(news.step);
    if (news.kind == kBegins) text << " of " << count << ", ";
    if (news.kind == kAgain) text << " again: ";
    if (news.kind == kLeftOut) text << " skipped: ";
    text << news.what;
  }
  return text;
}

Sentence waiting_for(std::optional<std::uint8_t> late) {
  Sentence told;
  if (late) {
    told << "waiting for boat " << static_cast<float>(*late) << ", out of its slot";
  } else {
    told << "no longer waiting";
  }
  return told;
}

Sentence unit_is_late(double latency_s) {
  Sentence late;
  late << "navigation unit is " << hundredths(portable::nearest(100 * latency_s))
       << " s late (no TIMESYNC)";
  return late;
}

Sentence slot_is_taken(std::uint8_t by) {
  Sentence why;
  why << "boat " << static_cast<float>(by) << " has the same slot";
  return why;
}

Sentence too_deep(std::size_t depth, float certified) {
  Sentence why;
  why << "formation depth " << static_cast<float>(depth) << " exceeds FORM_DEPTH " << certified;
  return why;
}

Sentence link_is_closed(std::uint8_t links) {
  Sentence closed;
  closed << "MAVLink link " << static_cast<float>(std::countr_zero(links)) << " is not open";
  return closed;
}

}  // namespace flotilla::app
