// SPDX-License-Identifier: MIT
// MAVLink frames by the generated tables, independent of our decoder.
#pragma once

#include <cstdint>
#include <span>

#include "link/mavlink/signing.hpp"

namespace flotilla::fuzz {

/// A whole, valid MAVLink 2 frame; its first float that is neither finite nor, by the protocol, NaN
/// where the value is unknown: the field's name, else nullptr.
const char* unsound_number(std::span<const std::uint8_t> frame);

/// Writes the right checksum, and signature where the frame says that it has one, at their places in
/// what begins like a frame of a known message and is long enough.
void repair(std::span<std::uint8_t> bytes, link::Signing& signing, std::uint8_t link_id);

/// Bytes of the whole frame that begins here, 0 where none does.
std::size_t frame_size(std::span<const std::uint8_t> bytes);

}  // namespace flotilla::fuzz
