// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <vector>

#include "link/any_message.hpp"
#include "linux/mavlink/datagrams.hpp"

namespace flotilla::target {
namespace {

using testing::Bytes;

std::vector<Bytes> cut(std::span<const std::uint8_t> bytes) {
  std::vector<Bytes> out;
  each_datagram(bytes, [&](auto part) { out.emplace_back(part.begin(), part.end()); });
  return out;
}

TEST_CASE(
    "a tick's messages leave whole, in order, in as few datagrams of 500 bytes as that takes") {
  for (std::uint32_t seed = 0; seed < 200; ++seed) {
    CAPTURE(seed);
    testing::AnyMessage any(seed);
    link::MavlinkEncoder encoder({2, 1});
    Bytes tick;
    while (true) {
      const Bytes frame = testing::frame_of(encoder, any(1 + any.u32() % (testing::kMessages - 1)));
      if (tick.size() + frame.size() > 1400) break;
      tick.insert(tick.end(), frame.begin(), frame.end());
    }
    Bytes all;
    std::size_t before = 500;
    for (const Bytes& datagram : cut(tick)) {
      CHECK(datagram.size() <= 500);
      CHECK(before + link::read_header(datagram)->frame_bytes() > 500);
      before = datagram.size();
      for (std::size_t at = 0; at < datagram.size();) {
        const auto header = link::read_header(std::span(datagram).subspan(at));
        REQUIRE(header);
        at += header->frame_bytes();
        REQUIRE(at <= datagram.size());
      }
      all.insert(all.end(), datagram.begin(), datagram.end());
    }
    CHECK(all == tick);
  }
}

TEST_CASE("empty output gives no datagram, and bytes that are no message leave in one") {
  CHECK(cut({}).empty());
  const Bytes noise(700, 7);
  CHECK(cut(noise) == std::vector<Bytes>{noise});
}

}  // namespace
}  // namespace flotilla::target
