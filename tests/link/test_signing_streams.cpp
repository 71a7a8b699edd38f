// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "link/any_message.hpp"

namespace flotilla::link {
namespace {

TEST_CASE("of more senders than there is room for, the first ones are heard, the rest counted") {
  constexpr SigningKey kKey{9};
  constexpr std::uint64_t kClock = 1'000'000'000;
  Signing theirs, ours;
  theirs.start(kKey, kClock, 0);
  ours.start(kKey, kClock, 0);
  MavlinkDecoder decoder;
  Counters counters;
  std::size_t heard = 0;
  for (int sender = 0; sender < 300; ++sender) {
    MavlinkEncoder encoder(
        {static_cast<std::uint8_t>(1 + sender % 250), static_cast<std::uint8_t>(1 + sender / 250)});
    std::array<std::uint8_t, 300> frame;
    const std::size_t size = encoder.encode(Heartbeat{4, 11, 0, 0, 4}, frame, &theirs, 3);
    CHECK(decoder.fill(std::span(frame).first(size)) == size);
    while (decoder.next(counters, &ours)) ++heard;
  }
  CHECK(heard == Signing::kStreams);
  CHECK(counters.mavlink_signed == Signing::kStreams);
  CHECK(counters.mavlink_streams_full == 300 - Signing::kStreams);
}

}  // namespace
}  // namespace flotilla::link
