// SPDX-License-Identifier: MIT
// DroneCAN's bit packing: a field's bytes are little-endian, each byte's most significant bit comes
// first, and a last partial byte consists of its low bits.
// Source: DroneCAN specification, chapter 3.5.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace flotilla::link {

/// Writes fields in sequence and pads the last byte with zeros; the caller ensures that they fit.
class BitWriter {
 public:
  explicit BitWriter(std::span<std::uint8_t> out) : out_(out) {}

  void put(std::uint64_t value, unsigned bits) {
    for (; bits >= 8 && position_ % 8 == 0; value >>= 8U, bits -= 8, position_ += 8) {
      out_[position_ / 8] = static_cast<std::uint8_t>(value & 0xFFU);
    }
    for (; bits > 0; value >>= 8U) {
      const unsigned n = std::min(bits, 8U);
      put_byte(static_cast<unsigned>(value & ((1U << n) - 1U)), n);
      bits -= n;
    }
  }

  std::size_t size_bytes() const { return (position_ + 7) / 8; }

 private:
  /// The n low bits of a byte, which straddle at most two bytes of the stream.
  void put_byte(unsigned byte, unsigned n) {
    const std::size_t at = position_ / 8;
    const unsigned used = position_ % 8;
    const unsigned window = byte << (16U - n - used);
    const unsigned before = used == 0 ? 0U : out_[at];
    out_[at] = static_cast<std::uint8_t>(before | window >> 8U);
    if (used + n > 8) out_[at + 1] = static_cast<std::uint8_t>(window & 0xFFU);
    position_ += n;
  }

  std::span<std::uint8_t> out_;
  std::size_t position_ = 0;
};

/// Reads fields in sequence, beyond the end as zero; left() gives the bits that remain.
class BitReader {
 public:
  explicit BitReader(std::span<const std::uint8_t> in) : in_(in) {}

  std::size_t left() const { return in_.size() * 8 - std::min(position_, in_.size() * 8); }

  std::uint64_t take(unsigned bits) {
    std::uint64_t value = 0;
    unsigned done = 0;
    for (; bits - done >= 8 && position_ % 8 == 0; done += 8, position_ += 8) {
      value |= std::uint64_t{byte_at(position_ / 8)} << done;
    }
    for (; done < bits; done += 8) {
      value |= std::uint64_t{take_byte(std::min(bits - done, 8U))} << done;
    }
    return value;
  }

  std::int64_t take_signed(unsigned bits) {
    const std::uint64_t value = take(bits);
    const std::uint64_t sign = std::uint64_t{1} << (bits - 1U);
    return static_cast<std::int64_t>((value ^ sign) - sign);
  }

 private:
  unsigned take_byte(unsigned n) {
    const std::size_t at = position_ / 8;
    const unsigned used = position_ % 8;
    const unsigned second = used + n > 8 ? byte_at(at + 1) : 0U;
    const unsigned window = (byte_at(at) << 8U | second) >> (16U - n - used);
    position_ += n;
    return window & ((1U << n) - 1U);
  }

  unsigned byte_at(std::size_t i) const { return i < in_.size() ? in_[i] : 0U; }

  std::span<const std::uint8_t> in_;
  std::size_t position_ = 0;
};

}  // namespace flotilla::link
