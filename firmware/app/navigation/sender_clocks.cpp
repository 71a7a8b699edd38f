// SPDX-License-Identifier: MIT
#include "app/navigation/sender_clocks.hpp"

#include <algorithm>

#include "app/convert/convert.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kForgotten_us = 3'000'000, kReboot_us = 1'000'000;

}  // namespace

SenderClocks::Sender* SenderClocks::find(link::Address from) {
  auto* const found =
      std::ranges::find_if(senders_, [&](const Sender& s) { return s.from == from; });
  return found == senders_.end() ? nullptr : found;
}

/// A free entry, or that of the deepest sender if it is deeper than `rank`.
SenderClocks::Sender* SenderClocks::place_for(std::uint8_t rank, std::int64_t now_us) {
  Sender* last = nullptr;
  for (Sender& s : senders_) {
    if (s.from.system == 0 || now_us - s.arrived_us > kForgotten_us) return &s;
    if (last == nullptr || last->rank < s.rank) last = &s;
  }
  return rank < last->rank ? last : nullptr;
}

std::optional<SenderClocks::Stamp> SenderClocks::heard(link::Address from, std::uint8_t rank,
                                                       std::uint32_t time_boot_ms,
                                                       std::int64_t now_us) {
  std::int64_t stamp_us = std::int64_t{time_boot_ms} * 1000;
  Sender* sender = find(from);
  if (sender == nullptr) {
    sender = place_for(rank, now_us);
    if (sender == nullptr) return std::nullopt;
    *sender = {from, rank, stamp_us, now_us, {}};
  }
  stamp_us = convert::unwrapped_us(stamp_us, sender->stamp_us);
  // Counts from the last newer stamp: a restarted clock sends only older stamps at first.
  const std::int64_t silent_us = now_us - sender->arrived_us;
  const bool back = stamp_us < sender->stamp_us;
  const bool overtaken =
      back && (silent_us < kReboot_us || !is_restart(stamp_us, sender->stamp_us, silent_us));
  if (!overtaken) {
    if (back) sender->clock.reset();
    sender->rank = rank;
    sender->stamp_us = stamp_us;
    sender->arrived_us = now_us;
  }
  sender->clock.heard(stamp_us, now_us);
  const ClockOffset& clock = sender->clock;
  const std::int64_t lag_us = clock.was_answered() ? 0 : lag_us_.value_or(0);
  return Stamp{std::min(stamp_us + *clock.offset_us(), now_us) - lag_us,
               std::min(stamp_us + *clock.least_us(), now_us) - lag_us,
               clock.was_answered() || (lag_us_ && !clock.disputed()), overtaken};
}

void SenderClocks::answered(link::Address from, std::int64_t sent_us, std::int64_t read_us,
                            std::int64_t now_us) {
  if (Sender* sender = find(from)) {
    sender->clock.answered(sent_us, convert::unwrapped_us(read_us, sender->stamp_us), now_us);
  }
}

}  // namespace flotilla::app
