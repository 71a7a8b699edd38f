// SPDX-License-Identifier: MIT
// MAVLink messages as plain structs with the protocol's names and units (mavlink.io, common message
// set): those of messages.txt, made by generate.py as the firmware is built.
#pragma once

#include <cstdint>

#include "dialect/messages.hpp"
#include "link/mavlink/mav.hpp"

namespace flotilla::link {

/// A received message. std::monostate is one that this firmware does not read.
struct Received {
  Address from;
  Message message;
  Address target{};      ///< where the message names one, else 0, 0
  std::uint32_t id = 0;  ///< message id
  std::uint8_t sequence = 0;
  bool is_signed = false;  ///< with a good signature; forged messages are dropped before
};

}  // namespace flotilla::link
