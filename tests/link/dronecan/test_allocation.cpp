// SPDX-License-Identifier: MIT
// Node id allocation as bytes, and transfers that break the rules of splitting.
#include <doctest/doctest.h>

#include <algorithm>
#include <vector>

#include "link/dronecan/messages.hpp"

namespace flotilla::link {
namespace {

using Bytes = std::vector<std::uint8_t>;

TEST_CASE("an allocation reads back as it was written: node id, first part, piece of unique id") {
  for (const std::uint8_t size : {std::uint8_t{0}, std::uint8_t{6}, std::uint8_t{16}}) {
    for (const bool first : {false, true}) {
      Allocation sent{125, first, size, {}};
      for (std::uint8_t i = 0; i < size; ++i)
        sent.unique_id[i] = static_cast<std::uint8_t>(0xF0 + i);
      Payload payload;
      const std::size_t length = write_payload(sent, payload);
      CHECK(length == 1U + size);
      CHECK(payload[0] == (250 | int{first}));
      const auto read = read_allocation(std::span(payload).first(length));
      REQUIRE(read);
      CHECK(read->node_id == 125);
      CHECK(read->first_part == first);
      CHECK(read->size == size);
      CHECK(read->unique_id == sent.unique_id);
    }
  }
}

TEST_CASE("an empty payload is no allocation, nor is one longer than a unique id") {
  CHECK_FALSE(read_allocation(Bytes{}));
  CHECK(read_allocation(Bytes(17)));
  CHECK_FALSE(read_allocation(Bytes(18)));
}

TEST_CASE("a transfer longer than the longest possible is discarded as a whole") {
  TransferReceiver receiver;
  Counters counters;
  const Route route{16, TransferKind::kMessage, 1034, 30, 0};
  Bytes frame(8, 0x55);
  for (int k = 0; k < 12; ++k) {
    frame[7] = static_cast<std::uint8_t>((k == 0 ? 0x80 : 0) | (k % 2 != 0 ? 0x20 : 0) |
                                         (k == 11 ? 0x40 : 0));
    CHECK_FALSE(receiver.push(route, EscStatus::kType, frame, k, counters));
  }
  CHECK(counters.can_bad_frame == 3);  // from the tenth on: 64 bytes are kept
  CHECK(counters.can_received == 0);
}

TEST_CASE("a last frame without a complete checksum gives no transfer") {
  TransferReceiver receiver;
  Counters counters;
  const Route route{16, TransferKind::kMessage, 1034, 30, 0};
  CHECK_FALSE(receiver.push(route, EscStatus::kType, Bytes{0x80}, 0, counters));
  CHECK_FALSE(receiver.push(route, EscStatus::kType, Bytes{1, 0x60}, 1, counters));
  CHECK(counters.can_received == 0);
  CHECK(counters.can_bad_frame > 0);
}

}  // namespace
}  // namespace flotilla::link
