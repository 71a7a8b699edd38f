// SPDX-License-Identifier: MIT
// Payloads of checked MAVLink frames to messages.
#pragma once

#include <cstdint>
#include <span>

#include "link/mavlink/messages.hpp"

namespace flotilla::link {

/// payload: at most 255 bytes; bytes that the frame leaves out are zero. `out` becomes
/// std::monostate for a message that a boat does not read. Values are not validated: their users do
/// that.
void read_payload(std::span<const std::uint8_t> payload, std::uint32_t id, Message& out);

}  // namespace flotilla::link
