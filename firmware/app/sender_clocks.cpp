// SPDX-License-Identifier: MIT
#include "app/sender_clocks.hpp"

#include <algorithm>

#include "app/convert.hpp"

namespace flotilla::app {
namespace {

constexpr std::int64_t kForgotten_us = 3'000'000, kReboot_us = 1'000'000;

}  // namespace

SenderClocks::Sender* SenderClocks::find(link::Address from) {
  auto* const found =
      std::ranges::find_if(senders_, [&](const Sender& s) { return s.from == from; });
  return found == senders_.end() ? nullptr : found;
}

/// A free one, or that of the deepest where it is deeper.
SenderClocks::Sender* SenderClocks::place_for(std::size_t depth, std::int64_t now_us) {
  Sender* deepest = nullptr;
  for (Sender& s : senders_) {
    if (s.from.system == 0 || now_us - s.arrived_us > kForgotten_us) return &s;
    if (deepest == nullptr || deepest->depth < s.depth) deepest = &s;
  }
  return depth < deepest->depth ? deepest : nullptr;
}

std::optional<std::int64_t> SenderClocks::heard(link::Address from, std::size_t depth,
                                                std::uint32_t time_boot_ms, std::int64_t now_us) {
  std::int64_t stamp_us = std::int64_t{time_boot_ms} * 1000;
  Sender* sender = find(from);
  if (sender == nullptr) {
    sender = place_for(depth, now_us);
    if (sender == nullptr) return std::nullopt;
    *sender = {from, depth, stamp_us, now_us, {}};
  }
  stamp_us = convert::unwrapped_us(stamp_us, sender->stamp_us);
  if (stamp_us < sender->stamp_us - kReboot_us) sender->clock.reset();
  sender->depth = depth;
  sender->stamp_us = stamp_us;
  sender->arrived_us = now_us;
  sender->clock.heard(stamp_us, now_us);
  return std::min(stamp_us + *sender->clock.offset_us(), now_us);
}

void SenderClocks::answered(link::Address from, std::int64_t sent_us, std::int64_t read_us,
                            std::int64_t now_us) {
  if (Sender* sender = find(from)) {
    sender->clock.answered(sent_us, convert::unwrapped_us(read_us, sender->stamp_us), now_us);
  }
}

}  // namespace flotilla::app
