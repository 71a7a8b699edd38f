// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <optional>
#include <random>

#include "link/dronecan/messages.hpp"
#include "link/dronecan/transfer.hpp"
#include "link/dronecan_vectors.hpp"

namespace flotilla::link {
namespace {

using vectors::Bytes;
using vectors::bytes_of;

/// Pushes frames of one id at one instant; returns the transfers that they complete.
std::vector<Bytes> deliver(TransferReceiver& receiver, std::uint32_t can_id,
                           std::uint64_t signature, const std::vector<Bytes>& frames,
                           std::int64_t now_us = 0) {
  static Counters counters;
  const Route route = route_of(can_id).value();
  std::vector<Bytes> out;
  for (const Bytes& frame : frames) {
    const auto done =
        receiver.push(route, vectors::type_of(route, signature), frame, now_us, counters);
    if (done) out.emplace_back(done->payload.begin(), done->payload.end());
  }
  return out;
}

std::vector<Bytes> bytes_of_all(const std::vector<std::string_view>& frames) {
  std::vector<Bytes> out;
  for (const std::string_view frame : frames) out.push_back(bytes_of(frame));
  return out;
}

TEST_CASE("every captured and generated transfer is reassembled to its payload") {
  for (const vectors::Transfer& v : vectors::kTransfers) {
    CAPTURE(v.name);
    TransferReceiver receiver;
    const auto got = deliver(receiver, v.can_id, v.signature, bytes_of_all(v.frames));
    REQUIRE(got.size() == 1);
    CHECK(got[0] == bytes_of(v.payload));
  }
}

TEST_CASE("every payload is split into exactly the captured frames") {
  for (const vectors::Transfer& v : vectors::kTransfers) {
    CAPTURE(v.name);
    const Route route = route_of(v.can_id).value();
    CHECK(can_id_of(route) == v.can_id);
    std::array<CanFrame, 20> frames;
    const Bytes payload = bytes_of(v.payload);
    const auto type = vectors::type_of(route, v.signature);
    const std::size_t n = split_transfer(route, type, v.transfer_id, payload, frames);
    REQUIRE(n == v.frames.size());
    for (std::size_t i = 0; i < n; ++i) {
      CHECK(frames[i].id == v.can_id);
      CHECK(Bytes(frames[i].bytes().begin(), frames[i].bytes().end()) == bytes_of(v.frames[i]));
    }
    CHECK(split_transfer(route, type, v.transfer_id, payload, std::span(frames).first(n - 1)) == 0);
  }
}

TEST_CASE("a damaged transfer is not delivered, and the next good one is") {
  for (const vectors::Damaged& v : vectors::kDamaged) {
    CAPTURE(v.name);
    TransferReceiver receiver;
    const auto got = deliver(receiver, v.can_id, v.signature, bytes_of_all(v.frames));
    CHECK(got.size() == static_cast<std::size_t>(v.delivered));
    const Bytes payload(14, 0x5A);
    std::array<CanFrame, 3> frames;
    const Route route = route_of(v.can_id).value();
    REQUIRE(split_transfer(route, vectors::type_of(route, v.signature), 2, payload, frames) == 3);
    std::vector<Bytes> next;
    for (const CanFrame& f : frames) next.emplace_back(f.bytes().begin(), f.bytes().end());
    CHECK(deliver(receiver, v.can_id, v.signature, next) == std::vector<Bytes>{payload});
  }
}

TEST_CASE("the specification's log of node id allocation: every transfer of the server arrives") {
  TransferReceiver receiver;
  std::vector<Bytes> from_server;
  std::size_t anonymous = 0;
  for (const vectors::Logged& v : vectors::kLog) {
    const auto got = deliver(receiver, v.can_id, v.signature, {bytes_of(v.frame)});
    const bool server = route_of(v.can_id)->source != 0;
    if (!server) CHECK(route_of(v.can_id)->type == 1);  // without the discriminator
    if (!server) anonymous += got.size();
    if (server) from_server.insert(from_server.end(), got.begin(), got.end());
  }
  CHECK(from_server == std::vector<Bytes>{bytes_of("0044C08B635E05"),
                                          bytes_of("0044C08B635E05F4BC1096DF11"),
                                          bytes_of("FA44C08B635E05F4BC1096DF11A8BA5447")});
  CHECK(anonymous <= 3);
}

TEST_CASE("interleaved senders do not disturb each other") {
  TransferReceiver receiver;
  const Bytes payload(30, 7);
  std::vector<std::array<CanFrame, 5>> senders(24);
  for (std::size_t i = 0; i < senders.size(); ++i) {
    const Route route{16, TransferKind::kMessage, 1034, static_cast<std::uint8_t>(i + 1), 0};
    REQUIRE(split_transfer(route, EscStatus::kType, 3, payload, senders[i]) == 5);
  }
  std::size_t whole = 0;
  for (std::size_t part = 0; part < 5; ++part) {
    for (const auto& frames : senders) {
      const CanFrame& f = frames[part];
      whole += deliver(receiver, f.id, EscStatus::kType.signature,
                       {Bytes(f.bytes().begin(), f.bytes().end())})
                   .size();
    }
  }
  CHECK(whole == senders.size());
}

TEST_CASE("a repeated single-frame transfer is delivered again") {
  TransferReceiver receiver;
  const std::uint32_t id = can_id_of({24, TransferKind::kMessage, 1100, 21, 0});
  const std::uint64_t signature = ArmingStatus::kType.signature;
  CHECK(deliver(receiver, id, signature, {{0xFF, 0xC3}}, 0).size() == 1);
  CHECK(deliver(receiver, id, signature, {{0xFF, 0xC3}}, 100).size() == 1);
  CHECK(deliver(receiver, id, signature, {{0xFF, 0xC4}}, 200).size() == 1);
  CHECK(deliver(receiver, id, signature, {{0xFF, 0xC4}}, 5'000'000).size() == 1);
}

TEST_CASE("a transfer id of 32 and more is counted modulo 32, all 32 in turn are delivered") {
  TransferReceiver receiver;
  std::size_t whole = 0;
  for (unsigned tid = 0; tid < 70; ++tid) {
    std::array<CanFrame, 1> frame;
    const Route route{24, TransferKind::kMessage, 1100, 9, 0};
    REQUIRE(split_transfer(route, ArmingStatus::kType, static_cast<std::uint8_t>(tid), Bytes{1},
                           frame) == 1);
    whole +=
        deliver(receiver, frame[0].id, 1, {Bytes(frame[0].bytes().begin(), frame[0].bytes().end())})
            .size();
  }
  CHECK(whole == 70);
}

TEST_CASE("an id of more than 29 bits, or a service from or to node 0, has no route") {
  CHECK_FALSE(route_of(0x20000000U));
  CHECK_FALSE(route_of(can_id_of({24, TransferKind::kRequest, 1, 0, 21})));
  CHECK_FALSE(route_of(can_id_of({24, TransferKind::kRequest, 1, 10, 0})));
  const auto request = route_of(can_id_of({24, TransferKind::kRequest, 1, 10, 21}));
  REQUIRE(request);
  CHECK(request->destination == 21);
  CHECK(request->kind == TransferKind::kRequest);
}

TEST_CASE("random frames cause no crash, and a valid transfer after them still arrives") {
  constexpr std::uint32_t kSeed = 33;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  TransferReceiver receiver;
  Counters counters;
  std::int64_t now_us = 0;
  for (int i = 0; i < 200'000; ++i) {
    Bytes frame(random() % 10);
    for (auto& byte : frame) byte = static_cast<std::uint8_t>(random());
    const Route route{static_cast<std::uint8_t>(random() % 32), TransferKind::kMessage,
                      static_cast<std::uint16_t>(random() % 3),
                      static_cast<std::uint8_t>(1 + random() % 40), 0};
    now_us += static_cast<std::int64_t>(random() % 1000);
    const auto done = receiver.push(route, EscStatus::kType, frame, now_us, counters);
    if (done) REQUIRE(done->payload.size() <= 64);
  }
  const vectors::Transfer& good = vectors::kTransfers[12];
  CHECK(
      deliver(receiver, good.can_id, good.signature, bytes_of_all(good.frames), now_us + 3'000'000)
          .size() == 1);
}

}  // namespace
}  // namespace flotilla::link
