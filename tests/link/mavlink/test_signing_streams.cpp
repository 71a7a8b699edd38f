// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "link/any_message.hpp"

namespace flotilla::link {
namespace {

TEST_CASE("with more senders than entries, the first ones are accepted, the rest counted") {
  constexpr SigningKey kKey{9};
  constexpr std::uint64_t kClock = 1'000'000'000;
  constexpr std::size_t kStreams = 255;
  std::array<Signing::Stream, kStreams> room;
  Signing theirs, ours(room);
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
  CHECK(heard == kStreams);
  CHECK(counters.mavlink_signed == kStreams);
  CHECK(counters.mavlink_streams_full == 300 - kStreams);
}

TEST_CASE("a boat without room for senders accepts no signature, and signs its output") {
  constexpr SigningKey kKey{9};
  std::array<Signing::Stream, 1> room;
  Signing ours, theirs(room);
  ours.start(kKey, 1'000, 0);
  theirs.start(kKey, 1'000, 0);
  MavlinkEncoder encoder({1, 1});
  std::array<std::uint8_t, 300> frame;
  const auto signed_by = [&](Signing& signing) {
    return std::span(frame).first(encoder.encode(Heartbeat{4, 11, 0, 0, 4}, frame, &signing, 3));
  };
  CHECK(ours.check(signed_by(theirs)) == SignatureVerdict::kNoRoom);
  CHECK(theirs.check(signed_by(ours)) == SignatureVerdict::kGood);
}

}  // namespace
}  // namespace flotilla::link
