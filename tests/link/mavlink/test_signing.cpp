// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <array>
#include <initializer_list>
#include <random>
#include <vector>

#include "link/mavlink/decode.hpp"
#include "link/mavlink/encode.hpp"
#include "link/mavlink/signing.hpp"

namespace flotilla::link {
namespace {

using Bytes = std::vector<std::uint8_t>;
using enum SignatureVerdict;

constexpr std::uint64_t kNow = 37'500'000'000'000, kSecond = 100'000, kDay = 86'400 * kSecond;

SigningKey counting_key(std::uint8_t first = 0) {
  SigningKey key;
  for (std::uint8_t& byte : key) byte = first++;
  return key;
}

struct Room {
  std::array<Signing::Stream, 255> streams;
};

/// Has a key, and room for 255 senders.
struct Keyed : Room, Signing {
  explicit Keyed(std::uint64_t now = kNow, const SigningKey& key = counting_key())
      : Signing(streams) {
    start(key, now, 0);
  }
  Keyed(const Keyed&) = delete;
  Keyed& operator=(const Keyed&) = delete;
};

/// A sender that signs heartbeats.
struct Sender {
  Address self{1, 190};
  std::uint8_t link_id = 7;
  MavlinkEncoder encoder{self};

  Bytes frame(std::uint64_t at, const SigningKey& key = counting_key()) {
    Keyed signing(at - 1, key);
    Bytes bytes(300);
    bytes.resize(encoder.encode(Heartbeat{0, 6, 8, 0, 4}, bytes, &signing, link_id));
    return bytes;
  }
};

/// HEARTBEAT of 1/190, link id 7, signed at kNow with counting_key() by pymavlink 2.4.50.
const Bytes kByPymavlink{0xFD, 0x09, 0x01, 0x00, 0x00, 0x01, 0xBE, 0x00, 0x00, 0x00, 0x00, 0x00,
                         0x00, 0x00, 0x06, 0x08, 0x00, 0x04, 0x03, 0xBF, 0x12, 0x07, 0x00, 0xD8,
                         0x2D, 0x26, 0x1B, 0x22, 0x73, 0xD5, 0xEB, 0x7D, 0xFC, 0x1C};

TEST_CASE("a frame is signed, byte for byte, as pymavlink signs it") {
  CHECK(Sender().frame(kNow) == kByPymavlink);
  CHECK(Keyed().check(kByPymavlink) == kGood);
}

TEST_CASE("timestamps begin in 2015 and end in 2104, and no clock leaves that range") {
  CHECK(signing_time(1'420'070'400'000'000) == 0);
  CHECK(signing_time(1'420'070'401'000'019) == kSecond + 1);
  CHECK(signing_time(0) == 0);
  CHECK(signing_time(INT64_MIN) == 0);
  CHECK(signing_time(INT64_MAX) == (std::uint64_t{1} << 48U) - 1);
}

TEST_CASE("a boat without a key accepts nothing, not even messages signed with zeros") {
  Signing none;
  CHECK_FALSE(none.has_key());
  CHECK(none.check(Sender().frame(1, SigningKey{})) == kForged);
}

TEST_CASE("a frame with any bit changed is a forgery") {
  Keyed boat;
  for (std::size_t bit = 0; bit < 8 * kByPymavlink.size(); ++bit) {
    Bytes changed = kByPymavlink;
    changed[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    CAPTURE(bit);
    CHECK(boat.check(changed) == kForged);
  }
  CHECK(boat.check(Sender().frame(kNow, counting_key(1))) == kForged);
  CHECK(boat.check(kByPymavlink) == kGood);
}

TEST_CASE("a frame too short for a signature counts as forged") {
  Keyed boat;
  for (std::size_t size = 0; size < kByPymavlink.size(); ++size) {
    CHECK(boat.check(std::span(kByPymavlink).first(size)) == kForged);
  }
}

TEST_CASE(
    "a forgery with any timestamp has no effect: messages with the right key are still accepted") {
  Keyed boat;
  Sender operator_, forger;
  for (const std::uint64_t at : {kNow + 1, kNow + 50 * kSecond, kNow + kDay, kNow + 1000 * kDay}) {
    CHECK(boat.check(forger.frame(at, counting_key(9))) == kForged);
    CHECK(boat.timestamp() <= kNow + kSecond);
  }
  CHECK(boat.check(operator_.frame(kNow + 1)) == kGood);
}

TEST_CASE("a message is accepted once, and no older one is accepted after it") {
  Keyed boat;
  Sender sender;
  const Bytes first = sender.frame(kNow + 1), second = sender.frame(kNow + 2);
  CHECK(boat.check(first) == kGood);
  CHECK(boat.check(first) == kReplayed);
  CHECK(boat.check(sender.frame(kNow + 1)) == kReplayed);  // another message, not a newer stamp
  CHECK(boat.check(second) == kGood);
  CHECK(boat.check(first) == kReplayed);
  CHECK(boat.check(sender.frame(kNow + 3)) == kGood);
}

TEST_CASE("each system, component and link id has timestamps of its own") {
  Keyed boat;
  CHECK(boat.check(Sender{{1, 190}, 7}.frame(kNow + 10)) == kGood);
  CHECK(boat.check(Sender{{2, 190}, 7}.frame(kNow + 9)) == kGood);
  CHECK(boat.check(Sender{{1, 191}, 7}.frame(kNow + 8)) == kGood);
  CHECK(boat.check(Sender{{1, 190}, 8}.frame(kNow + 7)) == kGood);
  CHECK(boat.check(Sender{{1, 190}, 7}.frame(kNow + 10)) == kReplayed);
}

TEST_CASE("a sender may be a minute behind, no more, whether it is known or new") {
  Keyed boat;
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow - 60 * kSecond - 1)) == kStale);
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow - 60 * kSecond)) == kGood);
  boat.set_clock(kNow + kDay);
  for (const std::uint8_t system : std::initializer_list<std::uint8_t>{1, 2}) {
    CHECK(boat.check(Sender{{system, 1}}.frame(kNow)) == kStale);
    CHECK(boat.check(Sender{{system, 1}}.frame(kNow + kDay)) == kGood);
  }
}

TEST_CASE("recorded messages of a jammed sender are refused after a minute, at any pace") {
  for (const std::uint64_t pace : {kSecond / 10, kSecond, 50 * kSecond}) {
    Keyed boat;
    Sender sender;
    REQUIRE(boat.check(sender.frame(kNow)) == kGood);
    std::uint64_t clock = kNow + 3 * 3600 * kSecond;
    for (std::uint64_t k = 1; k <= 1000; ++k, clock += pace) {
      boat.set_clock(clock);
      REQUIRE(boat.check(sender.frame(kNow + k * kSecond)) == kStale);
    }
  }
}

TEST_CASE("delayed one by one, recorded messages do not keep their stream alive") {
  Keyed boat;
  Sender sender;
  std::uint64_t clock = kNow;
  int taken = 0;
  for (std::uint64_t k = 0; k < 100; ++k, clock += 50 * kSecond) {  // ten a second were sent
    boat.set_clock(clock);
    taken += boat.check(sender.frame(kNow + k * kSecond / 10)) == kGood ? 1 : 0;
  }
  CHECK(taken == 2);
}

TEST_CASE("a pymavlink sender that receives nothing is accepted all day, with lagging timestamps") {
  Keyed boat;
  Sender sender;
  std::uint64_t stamp = kNow;
  for (std::uint64_t minute = 0; minute < 24 * 60; ++minute) {
    boat.set_clock(kNow + minute * 59 * kSecond);
    REQUIRE(boat.check(sender.frame(stamp += minute % 10 == 0 ? 500 : 1)) == kGood);
  }
  boat.set_clock(kNow + 24 * 3600 * kSecond);  // after a silence it must learn the time first
  CHECK(boat.check(sender.frame(stamp + 1)) == kStale);
  CHECK(boat.check(sender.frame(kNow + 24 * 3600 * kSecond)) == kGood);
}

TEST_CASE(
    "without a clock, messages not older than the last voyage are accepted, and set the time") {
  Keyed boat;
  boat.start(counting_key(), kSecond, kNow);
  boat.set_clock(kSecond, false);
  CHECK_FALSE(boat.knows_clock());
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow - 60 * kSecond - 1)) == kStale);
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow + 30 * kDay)) == kGood);
  CHECK(boat.timestamp() == kNow + 30 * kDay);
  CHECK(boat.check(Sender{{2, 1}}.frame(kNow + 30 * kDay - 3600 * kSecond)) == kGood);
  boat.set_clock(kNow + 30 * kDay);  // learnt
  CHECK(boat.check(Sender{{3, 1}}.frame(kNow + 30 * kDay - 3600 * kSecond)) == kStale);
  CHECK(boat.check(Sender{{3, 1}}.frame(kNow + 31 * kDay)) == kFuture);
  CHECK(boat.check(Sender{{3, 1}}.frame(kNow + 30 * kDay)) == kGood);
}

bool is_heartbeat(const Message& message) { return std::holds_alternative<Heartbeat>(message); }

TEST_CASE("an exempt message is accepted at any age, but only once, and no older one after it") {
  Room room;
  Signing boat(room.streams, is_heartbeat);
  boat.start(counting_key(), kNow, 0);
  const Message beat = Heartbeat{}, other = Attitude{};
  for (const std::uint64_t at : {kNow - 300 * kDay, kNow - 299 * kDay, kNow + 2 * kDay}) {
    const Bytes frame = Sender{{1, 1}}.frame(at);
    CHECK_FALSE(boat.take_exemption(frame, other));
    CHECK(boat.take_exemption(frame, beat));
    CHECK_FALSE(boat.take_exemption(frame, beat));
    CHECK_FALSE(boat.take_exemption(Sender{{1, 1}}.frame(at - 1), beat));
  }
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow)) == kGood);  // this shuts out no sender
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow + 1)) == kGood);
  CHECK_FALSE(Keyed().take_exemption(Sender{{1, 1}}.frame(kNow), beat));
  CHECK(boat.timestamp() == kNow);
}

TEST_CASE("a year-old recording is refused by a boat that has just been switched on") {
  Keyed boat(kNow);
  CHECK(boat.check(Sender().frame(kNow - 365 * kDay)) == kStale);
}

TEST_CASE("a sender a day ahead is refused, and does not move the boat's time") {
  Keyed boat;
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow + kDay)) == kFuture);
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow + 60 * kSecond + 1)) == kFuture);
  CHECK(boat.timestamp() == kNow);
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow)) == kGood);
  CHECK(boat.check(Sender{{2, 1}}.frame(kNow)) == kGood);
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow + 60 * kSecond)) == kGood);
  CHECK(boat.timestamp() == kNow);
}

TEST_CASE("many small steps ahead do not get further than one: the limit follows the clock alone") {
  Keyed boat;
  Sender ratchet{{66, 6}};
  std::uint64_t at = kNow;
  for (int i = 0; i < 1000; ++i) {
    at += 50 * kSecond;
    CHECK(boat.check(ratchet.frame(at)) == (i == 0 ? kGood : kFuture));
    CHECK(boat.timestamp() == kNow);
  }
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow)) == kGood);
  boat.set_clock(kNow + kSecond);
  CHECK(boat.check(ratchet.frame(kNow + 61 * kSecond)) == kGood);
  CHECK(boat.check(ratchet.frame(kNow + 61 * kSecond + 1)) == kFuture);
}

TEST_CASE("255 senders are known; the next is refused, and the old ones are still obeyed") {
  Keyed boat;
  const auto sender = [](unsigned i) {
    return Sender{{static_cast<std::uint8_t>(i % 100 + 1), static_cast<std::uint8_t>(i / 100 + 1)}};
  };
  for (unsigned i = 0; i < 255; ++i) REQUIRE(boat.check(sender(i).frame(kNow + 1)) == kGood);
  CHECK(boat.check(sender(255).frame(kNow + 2)) == kNoRoom);
  CHECK(boat.timestamp() == kNow);
  for (unsigned i = 0; i < 255; ++i) {
    CHECK(boat.check(sender(i).frame(kNow + 1)) == kReplayed);
    CHECK(boat.check(sender(i).frame(kNow + 3)) == kGood);
  }
  CHECK(boat.check(sender(255).frame(kNow + 4)) == kNoRoom);
}

TEST_CASE("output stamps follow the clock, never back; input is judged by a clock set back") {
  Keyed boat;
  boat.set_clock(kNow + kSecond);
  CHECK(boat.timestamp() == kNow + kSecond);
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow + 61 * kSecond)) == kGood);
  CHECK(boat.timestamp() == kNow + kSecond);
  boat.set_clock(kNow - kDay);
  CHECK(boat.timestamp() == kNow + kSecond);
  CHECK(boat.check(Sender{{2, 1}}.frame(kNow)) == kFuture);
  CHECK(boat.check(Sender{{2, 1}}.frame(kNow - kDay)) == kGood);
  boat.set_clock(0);
  CHECK(boat.timestamp() == kNow + kSecond);
}

Bytes sent_by(Signing& boat, MavlinkEncoder& encoder, std::uint8_t link_id = 0) {
  Bytes bytes(300);
  bytes.resize(encoder.encode(Heartbeat{0, 11, 0, 1, 4}, bytes, &boat, link_id));
  return bytes;
}

TEST_CASE("a station 59 s ahead shuts out no sender with the right time, nor moves our stamps") {
  Keyed boat;
  Sender fast{{255, 190}};
  std::uint64_t clock = kNow;
  for (unsigned minute = 0; minute < 60; ++minute, clock += 60 * kSecond) {
    boat.set_clock(clock);
    for (std::uint64_t k = 0; k < 5; ++k) {
      REQUIRE(boat.check(fast.frame(clock + 59 * kSecond + k)) == kGood);
    }
    CHECK(boat.timestamp() == clock);
    // Senders not heard before, whose clock is right or slow by the same time.
    const auto system = static_cast<std::uint8_t>(1 + minute);
    CHECK(boat.check(Sender{{system, 1}}.frame(clock)) == kGood);
    CHECK(boat.check(Sender{{system, 2}}.frame(clock - 59 * kSecond)) == kGood);
    CHECK(boat.timestamp() == clock);
  }
}

TEST_CASE("beside a station 59 s ahead, every other boat accepts our messages, on every link") {
  Keyed boat;
  MavlinkEncoder links[2] = {MavlinkEncoder({2, 1}), MavlinkEncoder({2, 1})};
  Sender fast{{255, 190}};
  Keyed second(kNow), slow(kNow - 50 * kSecond);
  for (std::uint64_t k = 1; k <= 600; ++k) {  // ten a second
    const std::uint64_t clock = kNow + k * kSecond / 10;
    boat.set_clock(clock);
    second.set_clock(clock);
    slow.set_clock(clock - 50 * kSecond);
    const Bytes fasts = fast.frame(clock + 59 * kSecond);
    REQUIRE(boat.check(fasts) == kGood);
    REQUIRE(second.check(fasts) == kGood);
    REQUIRE(slow.check(fasts) == kFuture);
    for (const std::uint8_t link : std::initializer_list<std::uint8_t>{0, 1}) {
      const Bytes ours = sent_by(boat, links[link], link);
      REQUIRE(second.check(ours) == kGood);
      REQUIRE(slow.check(ours) == kGood);
      Keyed newcomer(clock);  // hears both for the first time
      REQUIRE(newcomer.check(fasts) == kGood);
      REQUIRE(newcomer.check(ours) == kGood);
    }
  }
}

TEST_CASE("started again with a clock that is behind, a boat sends newer stamps than before") {
  Keyed before, station;
  MavlinkEncoder encoder({2, 1});
  std::uint64_t clock = kNow + 40 * kSecond;
  before.set_clock(clock);
  for (int k = 0; k < 10; ++k) REQUIRE(station.check(sent_by(before, encoder)) == kGood);
  // The clock of the new start is right, or the station's was ahead with it: 40 s less, here.
  Keyed after;
  after.start(counting_key(), kNow, before.timestamp());
  CHECK(after.timestamp() == before.timestamp());
  for (int k = 0; k < 10; ++k) {
    CHECK(station.check(sent_by(after, encoder)) == kGood);
    CHECK(after.timestamp() == before.timestamp() + 1 + static_cast<std::uint64_t>(k));
  }
  // Messages are judged by the clock, and a first one must be newer than the stored time.
  CHECK(after.check(Sender{{1, 1}}.frame(before.timestamp())) == kStale);
  CHECK(after.check(Sender{{1, 1}}.frame(before.timestamp() + 1)) == kGood);
  CHECK(after.check(Sender{{1, 3}}.frame(kNow + 60 * kSecond)) == kGood);
  CHECK(after.check(Sender{{1, 3}}.frame(kNow + 60 * kSecond + 1)) == kFuture);
  after.set_clock(kNow + 3600 * kSecond);  // the clock has caught up
  CHECK(after.timestamp() == kNow + 3600 * kSecond);
}

TEST_CASE("a restart makes no recorded message valid again, and a sender is obeyed as it goes on") {
  Room room;
  Signing boat(room.streams, is_heartbeat);
  boat.start(counting_key(), kNow, 0);
  Sender sender;
  for (std::uint64_t s = 0; s < 59; ++s) REQUIRE(boat.check(sender.frame(kNow + s)) == kGood);
  boat.start(counting_key(), kNow + 2 * kSecond, kNow + kSecond);
  for (std::uint64_t s = 0; s < 59; ++s) CHECK(boat.check(sender.frame(kNow + s)) == kStale);
  CHECK(boat.check(Sender{{1, 190}, 8}.frame(kNow + kSecond)) == kStale);  // nor on another link
  // A stop is obeyed at any age, but admits no other old message.
  CHECK(boat.take_exemption(sender.frame(kNow - kDay), Heartbeat{}));
  CHECK(boat.check(sender.frame(kNow + 58)) == kStale);
  CHECK(boat.check(sender.frame(kNow + kSecond + 1)) == kGood);
  CHECK(boat.check(sender.frame(kNow + kSecond + 2)) == kGood);
}

TEST_CASE("with a guessed clock no sender may start before the stored timestamp") {
  for (const std::uint64_t guess : {kNow - kDay, kNow, kNow + 3600 * kSecond}) {
    Keyed boat;
    boat.start(counting_key(), guess, kNow);
    boat.set_clock(guess, false);
    CHECK(boat.check(Sender{{1, 1}}.frame(kNow)) == kStale);
    CHECK(boat.check(Sender{{1, 2}}.frame(kNow + 1)) == kGood);
    CHECK(boat.check(Sender{{1, 3}}.frame(kNow + kDay)) == kGood);
  }
}

TEST_CASE(
    "a time stored a year ahead, by a wrong clock, does not make the boat refuse any sender") {
  Keyed boat;
  boat.start(counting_key(), kNow, kNow + 365 * kDay);
  CHECK(boat.check(Sender{{1, 1}}.frame(kNow)) == kGood);
  CHECK(boat.check(Sender{{1, 2}}.frame(kNow + 365 * kDay)) == kFuture);
  MavlinkEncoder encoder({2, 1});
  (void)sent_by(boat, encoder);
  CHECK(boat.timestamp() == kNow + 365 * kDay + 1);
}

TEST_CASE("with an earlier stored time, or none, a boat stamps its messages by its clock") {
  for (const std::uint64_t stored : {std::uint64_t{0}, kNow - 365 * kDay, kNow}) {
    Keyed boat;
    boat.start(counting_key(), kNow, stored);
    CHECK(boat.timestamp() == kNow);
  }
}

TEST_CASE("every stamp is newer than all that were sent or received, and than the clock") {
  constexpr std::uint32_t kSeed = 77;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  Keyed boat;
  MavlinkEncoder links[2] = {MavlinkEncoder({2, 1}), MavlinkEncoder({2, 1})};
  std::uint64_t last = 0, clock = kNow;
  for (int i = 0; i < 2000; ++i) {
    if (random() % 3 == 0) boat.set_clock(clock += random() % 100);
    if (random() % 50 == 0) boat.set_clock(clock - random() % kDay);
    if (random() % 3 == 0) (void)boat.check(Sender().frame(clock + random() % 1000));
    const std::size_t link = random() % 2;
    const std::uint64_t known = boat.timestamp();
    Bytes bytes(300);
    bytes.resize(links[link].encode(Heartbeat{}, bytes, &boat, static_cast<std::uint8_t>(link)));
    std::uint64_t stamp = 0;
    for (std::size_t k = 0; k < 6; ++k)
      stamp |= std::uint64_t{bytes[bytes.size() - 12 + k]} << 8 * k;
    CHECK(bytes[bytes.size() - 13] == link);
    CHECK(stamp > last);
    CHECK(stamp > known);
    last = stamp;
  }
}

TEST_CASE("a second start forgets the senders and follows the new key") {
  Keyed boat;
  CHECK(boat.check(Sender().frame(kNow + 5)) == kGood);
  boat.start(counting_key(1), kNow, 0);
  CHECK(boat.check(Sender().frame(kNow + 6)) == kForged);
  CHECK(boat.check(Sender().frame(kNow + 5, counting_key(1))) == kGood);
}

// Decoder and encoder with signing.

struct Link {
  MavlinkDecoder decoder;
  Counters counters;

  std::vector<Received> hear(std::span<const std::uint8_t> bytes, Signing* signing) {
    std::vector<Received> all;
    while (!bytes.empty()) {
      bytes = bytes.subspan(decoder.fill(bytes));
      while (auto received = decoder.next(counters, signing)) all.push_back(*received);
    }
    return all;
  }
};

TEST_CASE(
    "a link with a key delivers well-signed and unsigned messages, and marks the signed ones") {
  Keyed boat;
  Link link;
  const auto good = link.hear(kByPymavlink, &boat);
  REQUIRE(good.size() == 1);
  CHECK(good[0].is_signed);
  CHECK(good[0].from == Address{1, 190});
  Bytes unsigned_frame(300);
  unsigned_frame.resize(MavlinkEncoder({1, 190}).encode(Heartbeat{}, unsigned_frame));
  const auto plain = link.hear(unsigned_frame, &boat);
  REQUIRE(plain.size() == 1);
  CHECK_FALSE(plain[0].is_signed);
  CHECK(link.counters.mavlink_signed == 1);
  CHECK(link.counters.mavlink_received == 2);
}

TEST_CASE("a link with a key skips a badly signed frame whole, and counts why") {
  Keyed boat;
  Link link;
  Sender sender;
  Bytes stream = sender.frame(kNow, counting_key(1));
  const auto add = [&](const Bytes& frame) {
    stream.insert(stream.end(), frame.begin(), frame.end());
  };
  add(sender.frame(kNow + kDay));
  add(Sender{{9, 9}}.frame(kNow - kDay));
  add(sender.frame(kNow));
  add(sender.frame(kNow));
  add(sender.frame(kNow + 1));
  const auto got = link.hear(stream, &boat);
  CHECK(got.size() == 2);
  for (const Received& each : got) CHECK(each.is_signed);
  CHECK(link.counters.mavlink_forged == 1);
  CHECK(link.counters.mavlink_future_stamp == 1);
  CHECK(link.counters.mavlink_replayed == 2);
  CHECK(link.counters.mavlink_signed == 2);
  CHECK(link.counters.mavlink_received == 2);
  CHECK(link.counters.mavlink_skipped_bytes == 0);
}

TEST_CASE("a link without a key delivers signed frames, but never as signed") {
  Link link;
  const auto got = link.hear(Sender().frame(kNow, counting_key(1)), nullptr);
  REQUIRE(got.size() == 1);
  CHECK_FALSE(got[0].is_signed);
  CHECK(link.counters.mavlink_signed == 0);
}

TEST_CASE("a buffer with room for the message but not for its signature takes nothing") {
  Keyed boat;
  MavlinkEncoder encoder({1, 190});
  Bytes out(kByPymavlink.size() - 1, 0xEE);
  CHECK(encoder.encode(Heartbeat{0, 6, 8, 0, 4}, out, &boat, 7) == 0);
  CHECK(out == Bytes(out.size(), 0xEE));
  CHECK(boat.timestamp() == kNow);
  out.resize(kByPymavlink.size());
  CHECK(encoder.encode(Heartbeat{0, 6, 8, 0, 4}, out, &boat, 7) == kByPymavlink.size());
  CHECK(out[4] == 0);
}

}  // namespace
}  // namespace flotilla::link
