// SPDX-License-Identifier: MIT
// Payloads of checked MAVLink frames to messages.
#pragma once

#include <cstdint>
#include <span>

#include "link/mavlink/messages.hpp"

namespace flotilla::link {

/// At most 255 bytes; what the frame leaves out is zero. std::monostate for a message that a boat
/// does not read. Numbers are as they came: whoever uses one checks it.
void read_payload(std::span<const std::uint8_t> payload, std::uint32_t id, Message& out);

/// Whom a TIMESYNC is for. The two bytes came later than the generated code, which does not know
/// them; a sender that does not know them either leaves them out.
Address timesync_target(std::span<const std::uint8_t> payload);

}  // namespace flotilla::link
