// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>

#include <array>
#include <random>
#include <vector>

#include "link/dronecan/bit_stream.hpp"

namespace flotilla::link {
namespace {

TEST_CASE("two 14-bit commands are packed into four bytes as in DroneCAN's capture") {
  std::array<std::uint8_t, 4> out{};
  BitWriter writer(out);
  writer.put(8191, 14);
  writer.put(0x2000, 14);  // −8192
  CHECK(writer.size_bytes() == 4);
  CHECK(out == std::array<std::uint8_t, 4>{0xFF, 0x7C, 0x02, 0x00});
  BitReader reader(out);
  CHECK(reader.take_signed(14) == 8191);
  CHECK(reader.take_signed(14) == -8192);
  CHECK(reader.left() == 4);
}

TEST_CASE("whole bytes stand little-endian") {
  std::array<std::uint8_t, 8> out{};
  BitWriter writer(out);
  writer.put(0x0807060504030201ULL, 64);
  CHECK(out == std::array<std::uint8_t, 8>{1, 2, 3, 4, 5, 6, 7, 8});
}

TEST_CASE("the last byte is filled with zeros, and nothing is written behind it") {
  for (unsigned bits = 1; bits <= 24; ++bits) {
    std::array<std::uint8_t, 4> out{0xAA, 0xAA, 0xAA, 0xAA};
    BitWriter writer(out);
    for (unsigned i = 0; i < bits; ++i) writer.put(0, 1);
    std::array<std::uint8_t, 4> expected{0xAA, 0xAA, 0xAA, 0xAA};
    for (unsigned i = 0; i < (bits + 7) / 8; ++i) expected[i] = 0;
    CHECK(out == expected);
  }
}

TEST_CASE("a field of any width at any position is read back, and its neighbours do not change") {
  constexpr std::uint32_t kSeed = 31;
  INFO("seed ", kSeed);
  std::mt19937 random(kSeed);
  for (int run = 0; run < 500; ++run) {
    struct Field {
      unsigned bits;
      std::uint64_t value;
    };
    std::vector<Field> fields(20);
    std::array<std::uint8_t, 20 * 8> bytes;
    bytes.fill(static_cast<std::uint8_t>(random()));  // whatever was there before
    BitWriter writer(bytes);
    std::size_t bits = 0;
    for (Field& field : fields) {
      field.bits = 1 + random() % 64;
      const std::uint64_t any = std::uint64_t{random()} << 32U | random();
      field.value = field.bits == 64 ? any : any & ((std::uint64_t{1} << field.bits) - 1U);
      writer.put(field.value, field.bits);
      bits += field.bits;
    }
    CHECK(writer.size_bytes() == (bits + 7) / 8);
    BitReader reader(bytes);
    BitReader signed_reader(bytes);
    for (const Field& field : fields) {
      CHECK(reader.take(field.bits) == field.value);
      const unsigned unused = 64 - field.bits;
      if (field.bits == 64) {
        signed_reader.take(64);
        continue;
      }
      CHECK(signed_reader.take_signed(field.bits) ==
            static_cast<std::int64_t>(field.value << unused) >> unused);
    }
  }
}

TEST_CASE("a signed field of 64 bits is read back") {
  const std::array<std::uint8_t, 8> bytes{1, 0, 0, 0, 0, 0, 0, 0};
  CHECK(BitReader(bytes).take_signed(64) == 1);
}

TEST_CASE("reading beyond the end gives zeros, and left() reports it beforehand") {
  const std::array<std::uint8_t, 1> byte{0xFF};
  BitReader reader(byte);
  CHECK(reader.left() == 8);
  CHECK(reader.take(4) == 0xF);
  CHECK(reader.left() == 4);
  CHECK(reader.take(16) == 0xF0);
  CHECK(reader.left() == 0);
  CHECK(reader.take(64) == 0);
  CHECK(reader.left() == 0);
  BitReader empty(std::span<const std::uint8_t>{});
  CHECK(empty.left() == 0);
  CHECK(empty.take(3) == 0);
}

TEST_CASE("a value wider than its field loses its upper bits") {
  std::array<std::uint8_t, 2> out{};
  BitWriter writer(out);
  writer.put(0xFF, 4);
  writer.put(0, 4);
  writer.put(1, 8);
  CHECK(out == std::array<std::uint8_t, 2>{0xF0, 0x01});
}

}  // namespace
}  // namespace flotilla::link
