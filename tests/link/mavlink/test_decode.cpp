// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>

#include "link/any_message.hpp"
#include "link/mavlink/decode.hpp"

namespace flotilla::link {
namespace {

using testing::AnyMessage;
using testing::as_read;
using testing::Bytes;
using testing::fields_of;
using testing::frame_of;
using testing::received_from;

Bytes operator+(Bytes a, const Bytes& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Number of these messages that equal that one as a boat receives it.
std::size_t count_of(const std::vector<Received>& got, const Message& message) {
  const auto fields = fields_of(as_read(message));
  return static_cast<std::size_t>(std::ranges::count_if(
      got, [&](const Received& r) { return fields_of(r.message) == fields; }));
}

/// Longer than any frame, even one whose length is damaged.
const Bytes kQuiet(300, 0);

TEST_CASE("a message split at any byte, or byte by byte, arrives once and with its last byte") {
  constexpr std::uint32_t kSeed = 43;
  INFO("seed ", kSeed);
  AnyMessage any(kSeed);
  MavlinkEncoder encoder({1, 1});
  Counters counters;
  for (std::size_t index = 1; index < testing::kMessages; ++index) {
    const Message message = any(index);
    const Bytes frame = frame_of(encoder, message);
    const std::span<const std::uint8_t> all(frame);
    for (std::size_t cut = 1; cut < frame.size(); ++cut) {
      MavlinkDecoder decoder;
      REQUIRE(received_from(decoder, all.first(cut), counters).empty());
      REQUIRE(count_of(received_from(decoder, all.subspan(cut), counters), message) == 1);
    }
    MavlinkDecoder decoder;
    for (std::size_t i = 0; i + 1 < frame.size(); ++i) {
      REQUIRE(received_from(decoder, all.subspan(i, 1), counters).empty());
    }
    REQUIRE(received_from(decoder, all.last(1), counters).size() == 1);
  }
}

TEST_CASE("all messages in one chunk arrive, in order") {
  AnyMessage any(44);
  MavlinkEncoder encoder({1, 1});
  MavlinkDecoder decoder;
  Counters counters;
  Bytes stream;
  std::vector<std::vector<long double>> sent, got;
  for (std::size_t i = 0; i < 500; ++i) {
    const Message message = any(1 + i % (testing::kMessages - 1));
    sent.push_back(fields_of(as_read(message)));
    stream = stream + frame_of(encoder, message);
  }
  for (const Received& r : received_from(decoder, stream, counters)) {
    got.push_back(fields_of(r.message));
  }
  CHECK(got == sent);
}

// One in some thousands is an exception: noise that ends like the header of a message unknown here,
// whose end falls by chance on a start byte within the good message.
TEST_CASE("a good message is delivered, whatever noise comes before it") {
  constexpr std::uint32_t kSeed = 45;
  INFO("seed ", kSeed);
  AnyMessage any(kSeed);
  MavlinkEncoder encoder({1, 1});
  int lost = 0;
  for (unsigned run = 0; run < 600; ++run) {
    Bytes noise(any.u32() % 700);
    for (auto& byte : noise) {
      const std::uint8_t start = any.u8() % 2 == 0 ? 0xFD : 0xFE;
      byte =
          run % 3 == 0 ? any.u8() : (run % 3 == 1 ? start : (any.u8() % 4 == 0 ? start : any.u8()));
    }
    const Message message = any(1 + run % (testing::kMessages - 1));
    MavlinkDecoder decoder;
    Counters counters;
    const auto got = received_from(decoder, noise + frame_of(encoder, message) + kQuiet, counters);
    CAPTURE(run);
    lost += got.empty() ? 1 : 0;
    if (got.empty()) continue;
    REQUIRE(count_of(got, message) == 1);
    REQUIRE(got.size() == 1);
  }
  CHECK(lost <= 1);
}

// A broken header may look like that of a message outside our dialect, whose end falls by chance on
// a start byte. The bytes in between are then lost, but never those after the longest possible
// frame. A frame that lacks only its last byte is whole again with the next frame's first byte, if
// the two are equal.
TEST_CASE("a truncated message destroys hardly any of those after it") {
  constexpr std::uint32_t kSeed = 46;
  INFO("seed ", kSeed);
  AnyMessage any(kSeed);
  MavlinkEncoder encoder({1, 1});
  std::size_t tried = 0, lost = 0;
  for (std::size_t index = 1; index < testing::kMessages; ++index) {
    const Message first = any(index), next = any(2), last = any(3), later = any(5);
    const Bytes broken = frame_of(encoder, first);
    Bytes after;
    for (const Message& message : {next, last}) after = after + frame_of(encoder, message);
    after = after + kQuiet + frame_of(encoder, later) + kQuiet;
    for (std::size_t length = 0; length < broken.size(); ++length) {
      MavlinkDecoder decoder;
      Counters counters;
      const Bytes part(broken.begin(), broken.begin() + static_cast<std::ptrdiff_t>(length));
      const auto got = received_from(decoder, part + after, counters);
      CAPTURE(index);
      CAPTURE(length);
      REQUIRE(count_of(got, later) == 1);
      const std::size_t arrived = count_of(got, next) + count_of(got, last);
      const bool whole = length + 1 == broken.size() && broken.back() == 0xFD;
      REQUIRE(got.size() == arrived + 1 + (whole ? count_of(got, first) : 0));
      tried += 2;
      lost += 2 - arrived;
    }
  }
  CHECK(tried > 3000);
  CHECK(lost <= tried / 100);
}

/// Decodes as a host does that knows that no more bytes will come.
std::vector<Received> give_up(MavlinkDecoder& decoder, Counters& counters) {
  std::vector<Received> out;
  while (decoder.has_bytes()) {
    const std::uint32_t skipped = counters.mavlink_skipped_bytes;
    decoder.give_up(counters);
    CHECK(counters.mavlink_skipped_bytes == skipped + 1);
    while (const auto received = decoder.next(counters)) out.push_back(*received);
  }
  return out;
}

/// Whether no byte except the first can be mistaken for the beginning of a message.
bool is_plain(std::span<const std::uint8_t> frame) {
  return std::ranges::none_of(frame.subspan(1), [](auto b) { return b == 0xFD || b == 0xFE; });
}

TEST_CASE("once a message truncated at any byte is abandoned, all messages after it are found") {
  constexpr std::uint32_t kSeed = 50;
  INFO("seed ", kSeed);
  AnyMessage any(kSeed);
  MavlinkEncoder encoder({1, 1});
  std::size_t tried = 0;
  for (std::size_t index = 1; index < testing::kMessages; ++index) {
    const Message first = any(index), next = any(2), last = any(3);
    const Bytes broken = frame_of(encoder, first);
    if (!is_plain(broken)) continue;
    const Bytes after = frame_of(encoder, next) + frame_of(encoder, last);
    for (std::size_t length = 10; length < broken.size(); ++length) {
      MavlinkDecoder decoder;
      Counters counters;
      const Bytes part(broken.begin(), broken.begin() + static_cast<std::ptrdiff_t>(length));
      auto got = received_from(decoder, part + after, counters);
      const auto late = give_up(decoder, counters);
      got.insert(got.end(), late.begin(), late.end());
      CAPTURE(index);
      CAPTURE(length);
      if (length + 1 == broken.size() && broken.back() == 0xFD) continue;  // whole after all
      REQUIRE(got.size() == 2);
      REQUIRE(fields_of(got[0].message) == fields_of(as_read(next)));
      REQUIRE(fields_of(got[1].message) == fields_of(as_read(last)));
      REQUIRE(counters.mavlink_skipped_bytes == length);
      ++tried;
    }
  }
  CHECK(tried > 900);
}

// The cut-off bytes and those after them may form a header of a message outside our dialect whose
// end fits, even that of the datagram. The bytes in between are then lost, as they would be without
// giving up.
TEST_CASE("a message truncated in its header destroys hardly any of those behind it") {
  constexpr std::uint32_t kSeed = 51;
  INFO("seed ", kSeed);
  AnyMessage any(kSeed);
  MavlinkEncoder encoder({1, 1});
  std::size_t sent = 0, found = 0;
  for (std::size_t run = 0; run < 2000; ++run) {
    const Bytes broken = frame_of(encoder, any(1 + run % (testing::kMessages - 1)));
    const Message next = any(1 + any.u32() % (testing::kMessages - 1));
    const Bytes part(broken.begin(), broken.begin() + 1 + static_cast<std::ptrdiff_t>(run % 9));
    MavlinkDecoder decoder;
    Counters counters;
    const Bytes all = part + frame_of(encoder, next);
    const auto got = received_from(decoder, all, counters);
    ++sent;
    found += count_of(got, next) + count_of(give_up(decoder, counters), next);
  }
  CHECK(found >= sent - sent / 50);
}

TEST_CASE("with truncated messages abandoned at each datagram's end, no good message is lost") {
  constexpr std::uint32_t kSeed = 52;
  INFO("seed ", kSeed);
  AnyMessage any(kSeed);
  MavlinkEncoder encoder({1, 1});
  MavlinkDecoder decoder;
  Counters counters;
  std::size_t broken = 0;
  for (int k = 0; k < 2000; ++k) {
    Bytes datagram;
    std::vector<std::vector<long double>> sent, got;
    for (auto n = any.u32() % 8; n > 0; --n) {
      const Message message = any(1 + any.u32() % (testing::kMessages - 1));
      const Bytes frame = frame_of(encoder, message);
      if (any.u32() % 3 != 0) {
        datagram = datagram + frame;
        sent.push_back(fields_of(as_read(message)));
      } else if (is_plain(frame) && frame.size() > 13) {
        const std::size_t length = 10 + any.u32() % (frame.size() - 12);
        datagram.insert(datagram.end(), frame.begin(),
                        frame.begin() + static_cast<std::ptrdiff_t>(length));
        ++broken;
      }
    }
    std::span<const std::uint8_t> left(datagram);
    const auto take = [&](const std::vector<Received>& all) {
      for (const Received& r : all) got.push_back(fields_of(r.message));
    };
    while (!left.empty()) {  // in chunks of any size
      const std::size_t n = std::min<std::size_t>(left.size(), 1 + any.u32() % 400);
      take(received_from(decoder, left.first(n), counters));
      left = left.subspan(n);
    }
    take(give_up(decoder, counters));
    CAPTURE(k);
    REQUIRE(got == sent);
    REQUIRE_FALSE(decoder.has_bytes());
  }
  CHECK(broken > 1000);
}

TEST_CASE("whatever noise is abandoned, and when, every byte is counted and none is read twice") {
  constexpr std::uint32_t kSeed = 53;
  INFO("seed ", kSeed);
  AnyMessage any(kSeed);
  MavlinkEncoder encoder({1, 1});
  MavlinkDecoder decoder;
  Counters counters;
  std::size_t bytes = 0, in_frames = 0;
  for (int k = 0; k < 5000; ++k) {
    Bytes chunk(any.u32() % 300);
    for (auto& byte : chunk)
      byte = any.u8() % 8 == 0 ? (any.u8() % 2 == 0 ? 0xFD : 0xFE) : any.u8();
    if (k % 3 == 0) chunk = chunk + frame_of(encoder, any(1 + any.u32() % 20));
    bytes += chunk.size();
    std::span<const std::uint8_t> left(chunk);
    const auto read = [&] {
      while (decoder.next(counters)) in_frames += decoder.frame().size();
    };
    while (!left.empty()) {
      left = left.subspan(decoder.fill(left));
      read();
    }
    if (any.u32() % 4 == 0) decoder.give_up(counters);
    if (any.u32() % 4 != 0) continue;
    while (decoder.has_bytes()) {
      decoder.give_up(counters);
      read();
    }
    // Frames that look like messages of another dialect are in neither count.
    REQUIRE(in_frames + counters.mavlink_skipped_bytes <= bytes);
    if (counters.mavlink_unknown == 0) REQUIRE(in_frames + counters.mavlink_skipped_bytes == bytes);
  }
  CHECK(in_frames > 20'000);
  (void)give_up(decoder, counters);
  const std::uint32_t skipped = counters.mavlink_skipped_bytes;
  decoder.give_up(counters);  // nothing is waited for
  CHECK_FALSE(decoder.has_bytes());
  CHECK(counters.mavlink_skipped_bytes == skipped);
}

TEST_CASE("a message can be forwarded unchanged, whatever came before it") {
  constexpr std::uint32_t kSeed = 49;
  INFO("seed ", kSeed);
  AnyMessage any(kSeed);
  MavlinkEncoder encoder({1, 1});
  MavlinkDecoder decoder;
  Counters counters;
  for (std::size_t index = 1; index < testing::kMessages; ++index) {
    const Bytes one = frame_of(encoder, any(index)), other = frame_of(encoder, any(index));
    const Bytes stream = Bytes(index % 5, 0) + one + Bytes(index % 3, 0) + other;
    REQUIRE(decoder.fill(stream) == stream.size());
    for (const Bytes& sent : {one, other}) {
      REQUIRE(decoder.next(counters));
      CHECK(std::ranges::equal(decoder.frame(), sent));
    }
    CHECK(!decoder.next(counters));
    CHECK(decoder.frame().empty());
  }
}

TEST_CASE("the target of a message is read, and a broadcast is recognised") {
  MavlinkEncoder encoder({255, 190});
  MavlinkDecoder decoder;
  Counters counters;
  const auto target = [&](const Message& message) {
    const auto got = received_from(decoder, frame_of(encoder, message), counters);
    return got.size() == 1 ? got[0].target : Address{77, 77};
  };
  CHECK(target(Heartbeat{4, 10, 3, 81, 3}) == Address{});
  CHECK(target(ParamRequestList{{3, 4}}) == Address{3, 4});
  CHECK(target(CommandLong{400, {}, {3, 0}, 0}) == Address{3, 0});
  CHECK(target(ParamError{1, {3, 4}, {}, 1}) == Address{3, 4});  // that no boat reads
  CHECK(target(SetMode{5, 3, 1}) == Address{3, 0});
  CHECK(target(ManualControl{1, 2, 3, 4, 5, 3}) == Address{3, 0});
  CHECK(target(Timesync{1, 2, {}}) == Address{});
  CHECK(target(Timesync{1, 2, {3, 0}}) == Address{3, 0});
  CHECK(target(Timesync{1, 2, {0, 4}}) == Address{0, 4});
  CHECK(target(Timesync{1, 2, {3, 4}}) == Address{3, 4});
}

TEST_CASE("no message is looked for inside one of an unknown type") {
  AnyMessage any(48);
  MavlinkEncoder encoder({1, 1});
  const Bytes inner = frame_of(encoder, any(1)), behind = frame_of(encoder, any(2));
  Bytes unknown{0xFD, static_cast<std::uint8_t>(inner.size()), 0, 0, 7, 9, 1, 0x10, 0x27, 0};
  unknown = unknown + inner + Bytes{0x12, 0x34};
  MavlinkDecoder decoder;
  Counters counters;
  const auto got = received_from(decoder, unknown + unknown + behind, counters);
  CHECK(got.size() == 1);
  CHECK(counters.mavlink_unknown == 2);
  CHECK(counters.mavlink_skipped_bytes == 0);
}

TEST_CASE("a message with a flipped bit is not delivered, and its neighbours are") {
  AnyMessage any(47);
  MavlinkEncoder encoder({1, 1});
  for (std::size_t index = 1; index < testing::kMessages; ++index) {
    const Message before = any(1), next = any(2);
    const Bytes good = frame_of(encoder, any(index));
    const Bytes first = frame_of(encoder, before), after = frame_of(encoder, next) + kQuiet;
    for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
      Bytes bad = good;
      bad[bit / 8] = static_cast<std::uint8_t>(bad[bit / 8] ^ (1U << (bit % 8)));
      MavlinkDecoder decoder;
      Counters counters;
      const auto got = received_from(decoder, first + bad + after, counters);
      CAPTURE(bit);
      REQUIRE(got.size() == 2);
      REQUIRE(count_of(got, before) == 1);
      REQUIRE(count_of(got, next) == 1);
      REQUIRE(counters.mavlink_received == 2);
    }
  }
}

TEST_CASE("an old MAVLink 1 heartbeat is understood") {
  // HEARTBEAT of ArduPilot Rover in HOLD: system 3, component 1, sequence 0x12; extra byte 50.
  Bytes frame{0xFE, 9, 0x12, 3, 1, 0, 4, 0, 0, 0, 10, 3, 81, 3, 3};
  unsigned crc = 0xFFFF;
  const auto add = [&](unsigned byte) {
    unsigned x = (byte ^ crc) & 0xFFU;
    x = (x ^ x << 4U) & 0xFFU;
    crc = (crc >> 8U ^ x << 8U ^ x << 3U ^ x >> 4U) & 0xFFFFU;
  };
  for (std::size_t i = 1; i < frame.size(); ++i) add(frame[i]);
  add(50);
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8U));
  MavlinkDecoder decoder;
  Counters counters;
  const auto got = received_from(decoder, frame, counters);
  REQUIRE(got.size() == 1);
  CHECK(got[0].from.system == 3);
  CHECK(fields_of(got[0].message) == fields_of(Heartbeat{4, 10, 3, 81, 3}));
}

TEST_CASE("a million bytes of noise cause no crash and are all counted") {
  constexpr std::uint32_t kSeed = 48;
  INFO("seed ", kSeed);
  AnyMessage any(kSeed);
  MavlinkDecoder decoder;
  Counters counters;
  std::size_t bytes = 0, messages = 0;
  while (bytes < 1'000'000) {
    Bytes chunk(1 + any.u32() % 400);
    for (auto& byte : chunk)
      byte = any.u8() % 8 == 0 ? (any.u8() % 2 == 0 ? 0xFD : 0xFE) : any.u8();
    bytes += chunk.size();
    messages += received_from(decoder, chunk, counters).size();
  }
  CHECK(messages == counters.mavlink_received);
  CHECK(messages < 10);  // one in 65536 false frames has a good checksum
  CHECK(counters.mavlink_skipped_bytes > 990'000);
}

}  // namespace
}  // namespace flotilla::link
