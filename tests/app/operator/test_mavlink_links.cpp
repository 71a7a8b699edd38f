// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>
#include <random>

#include "app/operator/mavlink_links.hpp"
#include "link/any_message.hpp"

namespace flotilla::app {
namespace {

using testing::Bytes;
using testing::received_from;
constexpr link::Address kSelf{7, 1};
constexpr std::int64_t kTick_us = 10'000, kSecond_us = 1'000'000;
constexpr link::Attitude kAttitude{1, 0, 0, 1, 0, 0, 1};
constexpr link::Heartbeat kBeat{4, 11, 0, 1, 3};
constexpr std::uint64_t kNow = 37'500'000'000'000;  // a signing timestamp

struct Ship {
  std::array<MavlinkLinks::Link, 2> room;
  std::array<Datagram, 2> datagrams{};
  MavlinkLinks links{kSelf, room, datagrams};
  link::Counters counters;

  Bytes bytes(std::size_t link) const {
    const auto out = links.bytes(link);
    return {out.begin(), out.end()};
  }
  void send(std::size_t link, const link::Message& m) { links.send(link, m, counters); }

  /// Number of messages that these bytes complete.
  int come(std::span<const std::uint8_t> in, std::int64_t now_us) {
    CHECK(links.fill(0, in) == in.size());
    link::Received received;
    int found = 0;
    while (links.next(0, received, now_us, counters)) ++found;
    return found;
  }
};

Bytes any_bytes(std::size_t size, std::uint8_t first) {
  Bytes out(size);
  for (std::uint8_t& byte : out) byte = first++;
  return out;
}

TEST_CASE("each link has its own limit, and separate buckets for the state and for the rest") {
  Ship s;
  s.links.bucket(1).limit(1000);
  CHECK(s.links.bucket(0).limit() == 0);
  s.links.begin(kSecond_us);  // 300 and 200 bytes
  for (int k = 0; k < 20; ++k) s.send(0, kAttitude);
  CHECK(s.links.bucket(0).for_state());
  CHECK(s.links.bucket(0).for_rest());
  for (int k = 0; k < 5; ++k) {
    CHECK(s.links.bucket(1).for_rest());
    s.send(1, kAttitude);
  }
  CHECK_FALSE(s.links.bucket(1).for_rest());
  for (int k = 0; k < 8; ++k) {
    CHECK(s.links.bucket(1).for_state());
    s.links.send_state(1, kAttitude, s.counters);
  }
  CHECK_FALSE(s.links.bucket(1).for_state());
}

TEST_CASE("on average a limited link keeps to its limit, whatever it is given to send") {
  constexpr std::uint32_t kSeed = 31;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (const std::uint32_t rate_Bps : {200U, 1000U, 5700U, 20'000U}) {
    Ship s;
    s.links.bucket(0).limit(rate_Bps);
    std::int64_t sent = 0, time_us = 0;
    while (time_us < 120 * kSecond_us) {
      const auto dt_us = static_cast<std::int64_t>(1 + random() % 30'000);
      s.links.begin(dt_us);
      time_us += dt_us;
      while (s.links.bucket(0).for_state() && s.links.room(0) >= 700)
        s.links.send_state(0, kAttitude, s.counters);
      while (s.links.bucket(0).for_rest() && s.links.room(0) >= 40) s.send(0, kAttitude);
      sent += static_cast<std::int64_t>(s.links.bytes(0).size());
    }
    const double desired = double(rate_Bps) * double(time_us) / 1e6;
    CAPTURE(rate_Bps);
    CHECK(double(sent) <= desired + 80);
    CHECK(double(sent) >= desired - 80);
  }
}

TEST_CASE("messages dropped for lack of room use no credit") {
  Ship s;
  s.links.bucket(0).limit(4000);
  s.links.begin(kSecond_us);  // 1200 and 800 bytes
  for (int k = 0; k < 35; ++k) s.links.send_state(0, kAttitude, s.counters);
  REQUIRE(s.links.room(0) == 0);
  for (int k = 0; k < 1000; ++k) s.send(0, kAttitude);
  CHECK(s.links.bucket(0).for_rest());
  CHECK_FALSE(s.links.bucket(0).for_state());
}

TEST_CASE("forwarded traffic on a slow link uses the rest's share; the state is never late") {
  Ship s;
  s.links.bucket(0).limit(1000);
  const Bytes file = any_bytes(280, 1);
  std::size_t handed_on = 0, states = 0;
  for (int k = 0; k < 12'000; ++k) {  // two minutes of a file transfer
    s.links.forward(0, file, false, s.counters);
    s.links.forward(0, file, false, s.counters);
    s.links.begin(kTick_us);
    handed_on += s.links.bytes(0).size();
    if (k % 10 != 0) continue;
    states += s.links.bucket(0).for_state() ? 1U : 0U;
    s.links.send_state(0, kAttitude, s.counters);
  }
  CHECK(states == 1200);  // 400 of 600 B/s
  CHECK(handed_on >= 120 * 400);
  CHECK(handed_on <= 120 * 620);
}

TEST_CASE("a tick's output holds one datagram; a message beyond it is counted and uses no number") {
  Ship s;
  std::size_t sent = 0;
  while (s.links.room(0) >= 40) {
    s.send(0, kAttitude);
    sent += 40;
    REQUIRE(s.links.bytes(0).size() == sent);
    REQUIRE(s.links.room(0) == 1400 - sent);
  }
  s.send(0, kBeat);  // 21 bytes
  const Bytes full = s.bytes(0);
  CHECK(s.counters.mavlink_not_sent == (1400 - sent < 21 ? 1 : 0));
  const std::uint32_t before = s.counters.mavlink_not_sent;
  for (int k = 0; k < 300; ++k) s.send(0, kAttitude);
  CHECK(s.bytes(0) == full);
  CHECK(s.counters.mavlink_not_sent == before + 300);
  CHECK(s.links.room(1) == 1400);
  s.links.begin(kTick_us);
  CHECK(s.links.bytes(0).empty());
  s.send(0, kAttitude);
  link::MavlinkDecoder decoder;
  link::Counters counters;
  const auto was = received_from(decoder, full, counters);
  const auto now = received_from(decoder, s.bytes(0), counters);
  REQUIRE(now.size() == 1);
  CHECK(now[0].sequence == static_cast<std::uint8_t>(was.back().sequence + 1));
}

TEST_CASE("forwarded messages are sent unchanged with the next tick, before our own, and once") {
  Ship s;
  const Bytes first = any_bytes(280, 1), second = any_bytes(12, 200);
  s.links.begin(kTick_us);
  s.links.forward(1, first, false, s.counters);
  s.send(1, kBeat);
  CHECK(s.links.bytes(1).size() == 21);
  s.links.forward(1, second, false, s.counters);
  s.links.begin(kTick_us);
  Bytes both = first;
  both.insert(both.end(), second.begin(), second.end());
  CHECK(s.bytes(1) == both);
  CHECK(s.links.bytes(0).empty());
  CHECK(s.links.room(1) == 1400 - both.size());
  s.send(1, kBeat);
  CHECK(s.links.bytes(1).size() == both.size() + 21);
  s.links.begin(kTick_us);
  CHECK(s.links.bytes(1).empty());
  CHECK(s.counters.mavlink_not_sent == 0);
}

TEST_CASE(
    "400 bytes of a tick's output are for forwarding; a frame too many is dropped and counted") {
  constexpr std::uint32_t kSeed = 37;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (int round = 0; round < 500; ++round) {
    Ship s;
    Bytes expected;
    std::uint32_t refused = 0;
    for (int k = 0; k < 12; ++k) {
      const Bytes frame = any_bytes(12 + random() % 269, static_cast<std::uint8_t>(random()));
      if (expected.size() + frame.size() <= 400) {
        expected.insert(expected.end(), frame.begin(), frame.end());
      } else {
        ++refused;
      }
      s.links.forward(0, frame, false, s.counters);
    }
    s.links.begin(kTick_us);
    REQUIRE(s.bytes(0) == expected);
    REQUIRE(s.counters.mavlink_not_sent == refused);
  }
}

link::Received numbered(std::uint8_t sequence) {
  link::Received out{};
  out.from = kSelf;
  out.message = kBeat;
  out.sequence = sequence;
  return out;
}

TEST_CASE("an echo of our own heartbeat is recognised on any link, and no other one is") {
  Ship s;
  std::mt19937 random(41);
  link::MavlinkDecoder decoder;
  std::vector<link::Received> beats[2];
  for (int second = 0; second < 600; ++second) {  // sequence numbers turn over
    s.links.begin(kSecond_us);
    for (unsigned k = random() % 8; k > 0; --k) s.send(random() % 2, kAttitude);
    s.links.beat(kBeat, s.counters);
    for (std::size_t link = 0; link < 2; ++link) {
      for (const auto& r : received_from(decoder, s.bytes(link), s.counters)) {
        if (std::holds_alternative<link::Heartbeat>(r.message)) beats[link].push_back(r);
      }
      REQUIRE(beats[link].size() == static_cast<std::size_t>(second) + 1);
      REQUIRE(s.links.is_echo(beats[link].back()));
      if (second > 0) REQUIRE(s.links.is_echo(beats[link][static_cast<std::size_t>(second) - 1]));
    }
    int known = 0;
    for (unsigned sequence = 0; sequence < 256; ++sequence) {
      known += s.links.is_echo(numbered(static_cast<std::uint8_t>(sequence))) ? 1 : 0;
    }
    REQUIRE(known <= 16);  // eight of each link
  }
}

TEST_CASE("before the first heartbeat nothing is an echo") {
  const Ship s;
  for (unsigned sequence = 0; sequence < 256; ++sequence) {
    CHECK_FALSE(s.links.is_echo(numbered(static_cast<std::uint8_t>(sequence))));
  }
}

TEST_CASE("after a change of id every link continues its sequence numbers") {
  Ship s;
  link::MavlinkDecoder decoder;
  for (int k = 0; k < 3; ++k) s.send(0, kBeat);
  s.links.rename({42, 191});
  s.links.broadcast(kBeat, s.counters);
  const auto on_0 = received_from(decoder, s.bytes(0), s.counters);
  const auto on_1 = received_from(decoder, s.bytes(1), s.counters);
  REQUIRE(on_0.size() == 4);
  REQUIRE(on_1.size() == 1);
  CHECK(on_0[2].from == kSelf);
  CHECK(on_0[3].from == link::Address{42, 191});
  CHECK(on_1[0].from == link::Address{42, 191});
  for (std::uint8_t k = 0; k < 4; ++k) CHECK(on_0[k].sequence == k);
}

// A message that is cut off.

TEST_CASE("a good message after the false start of an abandoned one is found") {
  link::MavlinkEncoder encoder({255, 190});
  Bytes stream{0xFD, 200, 0, 0};
  const Bytes frame = testing::frame_of(encoder, kAttitude);
  stream.insert(stream.end(), frame.begin(), frame.end());
  Ship s;
  CHECK(s.come(stream, 0) == 0);
  link::Received received;
  int given_up = 0, found = 0;
  while (s.links.give_up(0, s.counters)) {
    ++given_up;
    while (s.links.next(0, received, 0, s.counters)) ++found;
  }
  CHECK(found == 1);
  CHECK(given_up >= 1);
  CHECK(s.counters.mavlink_skipped_bytes == 4);
  CHECK(std::ranges::equal(s.links.frame(0), frame));
}

TEST_CASE("an incomplete message is abandoned after 0.3 s, however slowly its bytes arrive") {
  const Bytes frame = [] {
    link::MavlinkEncoder encoder({255, 190});
    return testing::frame_of(encoder, kAttitude);
  }();
  for (std::size_t cut = 1; cut < frame.size(); ++cut) {
    Ship s;
    CHECK_FALSE(s.links.timed_out(0, kSecond_us));
    const auto all = std::span(frame);
    CHECK(s.come(all.first(1), 0) == 0);
    for (std::size_t k = 1; k < cut; ++k) {
      CHECK(s.come(all.subspan(k, 1), static_cast<std::int64_t>(k) * 7000) == 0);
    }
    CHECK_FALSE(s.links.timed_out(0, 300'000));
    CHECK(s.links.timed_out(0, 300'001));
    CHECK_FALSE(s.links.timed_out(1, 300'001));
    CHECK(s.come(all.subspan(cut), 300'001) == 1);  // still whole if it was not given up
    CHECK_FALSE(s.links.timed_out(0, 3600 * kSecond_us));
  }
}

TEST_CASE("the 0.3 s start anew with each message, even on a link that is never quiet") {
  link::MavlinkEncoder encoder({255, 190});
  Ship s;
  Bytes stream;
  while (stream.size() < 4000) {
    const Bytes frame = testing::frame_of(encoder, kAttitude);
    stream.insert(stream.end(), frame.begin(), frame.end());
  }
  std::int64_t now_us = 0;
  int found = 0;
  for (const std::uint8_t byte : stream) {  // 200 B/s: a message in 0.2 s
    found += s.come(std::span(&byte, 1), now_us += 5000);
    REQUIRE_FALSE(s.links.timed_out(0, now_us));
  }
  CHECK(found == static_cast<int>(stream.size() / 40));
}

// Reception under each policy of a link.

enum class Mark { kNone, kGood, kForged };

Bytes incoming(Mark mark, const link::Message& message, std::uint8_t component) {
  link::Signing signing;
  link::SigningKey key{1, 2, 3};
  if (mark == Mark::kForged) key[0] = 99;
  signing.start(key, kNow, 0);
  link::MavlinkEncoder encoder({255, component});
  Bytes out(300);
  out.resize(encoder.encode(message, out, mark == Mark::kNone ? nullptr : &signing, 5));
  return out;
}

std::optional<link::Received> let_in(SigningPolicy policy, bool key, Mark mark,
                                     const link::Message& message, link::Counters& counters,
                                     std::uint8_t component = 190, bool datagrams = false) {
  std::array<MavlinkLinks::Link, 2> room;
  std::array<Datagram, 2> out;
  std::array<link::Signing::Stream, 1> operators;
  MavlinkLinks links(kSelf, room, out, operators);
  if (key) links.signing().start({1, 2, 3}, kNow, 0);
  links.set_policy(1, policy);
  if (datagrams) links.set_datagrams(1);
  const Bytes bytes = incoming(mark, message, component);
  CHECK(links.fill(1, bytes) == bytes.size());
  link::Received received;
  CHECK_FALSE(links.next(0, received, 0, counters));
  return links.next(1, received, 0, counters) ? std::optional(received) : std::nullopt;
}

TEST_CASE("a link accepts messages by its policy, by key, by signature") {
  const link::Message command = link::CommandLong{400, {1, 0, 0, 0, 0, 0, 0}, kSelf, 0};
  for (const SigningPolicy policy :
       {SigningPolicy::kOff, SigningPolicy::kAccept, SigningPolicy::kRequired}) {
    for (const bool key : {false, true}) {
      for (const Mark mark : {Mark::kNone, Mark::kGood, Mark::kForged}) {
        const bool looks = policy != SigningPolicy::kOff && key;
        const bool good = looks && mark == Mark::kGood;
        const bool taken = policy == SigningPolicy::kRequired ? good
                           : looks                            ? mark != Mark::kForged
                                                              : true;
        link::Counters counters;
        const auto received = let_in(policy, key, mark, command, counters);
        CAPTURE(static_cast<int>(policy));
        CAPTURE(key);
        CAPTURE(static_cast<int>(mark));
        CHECK(received.has_value() == taken);
        if (received) CHECK(received->is_signed == good);
        CHECK(counters.mavlink_signed == (good ? 1 : 0));
        CHECK(counters.mavlink_forged == (looks && mark == Mark::kForged ? 1 : 0));
        CHECK(counters.mavlink_unsigned_refused ==
              (!taken && !(looks && mark == Mark::kForged) ? 1 : 0));
      }
    }
  }
}

TEST_CASE("RADIO_STATUS is accepted without a signature, but not with a false one") {
  link::Counters counters;
  const link::Message radio = link::RadioStatus{50};
  const auto taken = [&](bool key, Mark mark, std::uint8_t component, bool datagrams = false) {
    return let_in(SigningPolicy::kRequired, key, mark, radio, counters, component, datagrams)
        .has_value();
  };
  CHECK(taken(true, Mark::kNone, 68));
  CHECK(taken(false, Mark::kNone, 68));
  CHECK_FALSE(taken(true, Mark::kForged, 68));
  CHECK_FALSE(taken(true, Mark::kNone, 190));
  CHECK_FALSE(taken(true, Mark::kNone, 68, true));  // not on a serial line
}

TEST_CASE("a link with a key signs its output under its own id if its policy asks for that") {
  for (const bool key : {false, true}) {
    std::array<MavlinkLinks::Link, 3> room;
    std::array<Datagram, 3> out;
    MavlinkLinks links(kSelf, room, out);
    link::Counters counters;
    if (key) links.signing().start({1, 2, 3}, kNow, 0);
    links.set_policy(1, SigningPolicy::kAccept);
    links.set_policy(2, SigningPolicy::kRequired);
    links.broadcast(kBeat, counters);
    CHECK(links.bytes(0).size() == 21);
    for (const std::size_t link : {1U, 2U}) {
      REQUIRE(links.bytes(link).size() == (key ? 34 : 21));
      if (!key) continue;
      CHECK(links.bytes(link)[21] == link);
      std::array<link::Signing::Stream, 1> boats;
      link::Signing reader(boats);
      reader.start({1, 2, 3}, kNow, 0);
      CHECK(reader.check(links.bytes(link)) == link::SignatureVerdict::kGood);
    }
  }
}

TEST_CASE("the configuration's policy names are accepted, and no others") {
  CHECK(signing_policy("off") == SigningPolicy::kOff);
  CHECK(signing_policy("accept") == SigningPolicy::kAccept);
  CHECK(signing_policy("required") == SigningPolicy::kRequired);
  for (const char* name : {"", "Off", "require", "on", "true", "accept "}) {
    CHECK_FALSE(signing_policy(name).has_value());
  }
}

}  // namespace
}  // namespace flotilla::app
