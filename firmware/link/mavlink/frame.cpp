// SPDX-License-Identifier: MIT
#include "link/mavlink/frame.hpp"

#include <algorithm>
#include <array>

#include "link/mavlink/crc.hpp"

namespace flotilla::link {

std::optional<FrameHeader> read_header(std::span<const std::uint8_t> b) {
  if (b.size() >= kHeaderBytes2 && b[0] == kStart2) {
    const std::uint32_t id = b[7] | std::uint32_t{b[8]} << 8U | std::uint32_t{b[9]} << 16U;
    return FrameHeader{kHeaderBytes2, b[1], id, {b[5], b[6]}, b[4], b[2]};
  }
  if (b.size() >= kHeaderBytes1 && b[0] == kStart1) {
    return FrameHeader{kHeaderBytes1, b[1], b[5], {b[3], b[4]}, b[2], 0};
  }
  return std::nullopt;
}

bool checksum_is_good(std::span<const std::uint8_t> b, const FrameHeader& h,
                      std::uint8_t crc_extra) {
  const std::uint16_t crc = mavlink_crc(b.first(h.covered()).subspan(1), crc_extra);
  return b[h.covered()] == (crc & 0xFFU) && b[h.covered() + 1] == crc >> 8U;
}

std::size_t write_frame(const FrameType& type, std::span<const std::uint8_t> payload,
                        std::span<std::uint8_t> out) {
  std::size_t size = payload.size();
  while (size > 1 && payload[size - 1] == 0) --size;
  const std::size_t covered = kHeaderBytes2 + size;
  const std::size_t length = covered + kChecksumBytes;
  if (length + (type.is_signed ? kSignatureBlockBytes : 0) > out.size()) return 0;
  const auto byte = [](std::size_t number) { return static_cast<std::uint8_t>(number); };
  const std::array<std::uint8_t, kHeaderBytes2> header{kStart2,
                                                       byte(size),
                                                       type.is_signed ? kSignedFlag : byte(0),
                                                       0,
                                                       type.sequence,
                                                       type.self.system,
                                                       type.self.component,
                                                       byte(type.id),
                                                       byte(type.id >> 8U),
                                                       byte(type.id >> 16U)};
  std::copy(header.begin(), header.end(), out.begin());
  std::copy_n(payload.begin(), size, out.begin() + kHeaderBytes2);
  const std::uint16_t crc = mavlink_crc(out.first(covered).subspan(1), type.crc_extra);
  out[covered] = byte(crc & 0xFFU);
  out[covered + 1] = byte(crc >> 8U);
  return length;
}

}  // namespace flotilla::link
