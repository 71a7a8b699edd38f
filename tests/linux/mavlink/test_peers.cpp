// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <algorithm>

#include "linux/mavlink/peers.hpp"

namespace flotilla::target {
namespace {

constexpr std::int64_t kSecond_us = 1'000'000;

sockaddr_in at(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

bool knows(const Peers& peers, std::uint16_t port) {
  return std::ranges::any_of(
      peers.all(), [&](const Peers::Peer& p) { return p.address.sin_port == htons(port); });
}

/// Ports 1 … 8, heard in this order, a millisecond apart.
Peers full(bool is_signed) {
  Peers peers;
  for (std::uint16_t port = 1; port <= 8; ++port) peers.accepted(at(port), is_signed, 1000 * port);
  return peers;
}

TEST_CASE("a peer is answered until it was silent for half a minute") {
  Peers peers;
  peers.accepted(at(1), false, 0);
  peers.accepted(at(2), false, 0);
  peers.accepted(at(2), false, kSecond_us);
  peers.forget_silent(30 * kSecond_us - 1);
  CHECK(peers.all().size() == 2);
  peers.forget_silent(30 * kSecond_us);
  CHECK_FALSE(knows(peers, 1));
  CHECK(knows(peers, 2));
}

TEST_CASE("a ninth peer waits until one of the eight has missed three heartbeats") {
  Peers peers = full(false);
  peers.accepted(at(9), false, 10'000);
  CHECK_FALSE(knows(peers, 9));
  for (std::uint16_t port = 2; port <= 8; ++port) peers.accepted(at(port), false, kSecond_us);
  peers.accepted(at(9), false, 1000 + 3 * kSecond_us);
  CHECK(knows(peers, 9));
  CHECK_FALSE(knows(peers, 1));
  CHECK(peers.all().size() == 8);
}

TEST_CASE("a signing peer displaces the longest silent non-signing one, at once") {
  Peers peers = full(false);
  peers.accepted(at(9), true, 10'000);
  CHECK(knows(peers, 9));
  CHECK_FALSE(knows(peers, 1));
  CHECK(knows(peers, 2));
}

TEST_CASE("a peer that does not sign never displaces one that does, however silent") {
  Peers peers = full(true);
  peers.accepted(at(9), false, 29 * kSecond_us);
  CHECK_FALSE(knows(peers, 9));
  peers.accepted(at(10), true, 2 * kSecond_us);
  CHECK_FALSE(knows(peers, 10));
  peers.accepted(at(10), true, 4 * kSecond_us);
  CHECK(knows(peers, 10));
  CHECK_FALSE(knows(peers, 1));
}

TEST_CASE("an unsigned message from a signing peer's address does not keep its place") {
  Peers peers;
  peers.accepted(at(1), true, 0);
  peers.accepted(at(1), false, 29 * kSecond_us);
  CHECK(peers.all()[0].is_signed);
  peers.forget_silent(30 * kSecond_us);
  CHECK(peers.all().empty());
}

}  // namespace
}  // namespace flotilla::target
