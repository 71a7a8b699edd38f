// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include "link/any_message.hpp"
#include "link/mavlink/encode.hpp"

namespace flotilla::link {
namespace {

using testing::AnyMessage;
using testing::Bytes;
using testing::fields_of;
using testing::frame_of;

TEST_CASE("every message arrives with its sender, and unchanged if it is one that boats read") {
  constexpr std::uint32_t kSeed = 41;
  INFO("seed ", kSeed);
  AnyMessage any(kSeed);
  MavlinkEncoder encoder({7, 191});
  MavlinkDecoder decoder;
  Counters counters;
  for (int i = 0; i < 200; ++i) {
    for (std::size_t index = 1; index < testing::kMessages; ++index) {
      const Message sent = any(index);
      const auto got = testing::received_from(decoder, frame_of(encoder, sent), counters);
      CAPTURE(index);
      REQUIRE(got.size() == 1);
      CHECK(got[0].from.system == 7);
      CHECK(got[0].from.component == 191);
      CHECK(got[0].sequence == encoder.last_sequence());
      CHECK(fields_of(got[0].message) == fields_of(testing::as_read(sent)));
    }
  }
  CHECK(counters.mavlink_skipped_bytes == 0);
  CHECK(counters.mavlink_received == 200 * (testing::kMessages - 1));
}

TEST_CASE("a message of zeros, which is sent shortened, arrives as zeros") {
  MavlinkEncoder encoder({1, 1});
  MavlinkDecoder decoder;
  Counters counters;
  const Bytes frame = frame_of(encoder, LocalPositionNed{});
  CHECK(frame.size() < 20);
  const auto got = testing::received_from(decoder, frame, counters);
  REQUIRE(got.size() == 1);
  CHECK(fields_of(got[0].message) == fields_of(LocalPositionNed{}));
}

TEST_CASE("each encoder's own sequence numbers count from 0 to 255, then start again") {
  MavlinkEncoder encoder({1, 1}), other({1, 1});
  for (unsigned i = 0; i < 600; ++i) {
    const Bytes frame = frame_of(encoder, Heartbeat{});
    REQUIRE(frame[0] == 0xFD);
    CHECK(frame[4] == (i & 0xFFU));
    CHECK(encoder.last_sequence() == frame[4]);
    if (i == 300) CHECK(frame_of(other, Heartbeat{})[4] == 0);
  }
}

TEST_CASE("a buffer that is too short takes nothing and uses no sequence number") {
  AnyMessage any(42);
  for (std::size_t index = 1; index < testing::kMessages; ++index) {
    MavlinkEncoder encoder({1, 1});
    const Message message = any(index);
    MavlinkEncoder measure({1, 1});
    const std::size_t size = frame_of(measure, message).size();
    CAPTURE(index);
    for (std::size_t room = 0; room < size; ++room) {
      Bytes out(room, 0xEE);
      REQUIRE(encoder.encode(message, out) == 0);
      REQUIRE(out == Bytes(room, 0xEE));
    }
    Bytes exact(size);
    CHECK(encoder.encode(message, exact) == size);
    CHECK(exact[4] == 0);
    CHECK(encoder.last_sequence() == 0);
    Bytes none(size - 1);
    CHECK(encoder.encode(message, none) == 0);
    CHECK(encoder.last_sequence() == 0);
  }
}

TEST_CASE("an empty message sends nothing") {
  MavlinkEncoder encoder({1, 1});
  CHECK(frame_of(encoder, Message{}).empty());
  CHECK(frame_of(encoder, Heartbeat{})[4] == 0);
}

}  // namespace
}  // namespace flotilla::link
