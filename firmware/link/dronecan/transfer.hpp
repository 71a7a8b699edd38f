// SPDX-License-Identifier: MIT
// DroneCAN v0 transfers in classic CAN frames: identifier, tail byte, splitting and reassembly.
// Source: DroneCAN specification, chapter 4.1 "CAN bus transport layer".
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "link/counters.hpp"
#include "link/dronecan/can_frame.hpp"
#include "link/dronecan/crc16.hpp"

namespace flotilla::link {

enum class TransferKind : std::uint8_t { kMessage, kRequest, kResponse };

/// The CRC of a data type's signature, little-endian.
constexpr std::uint16_t crc_of_signature(std::uint64_t signature) {
  std::array<std::uint8_t, 8> bytes{};
  for (unsigned i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(signature >> (8U * i));
  return crc16(kCrc16Start, bytes);
}

/// A data type's id, and the seed of its multi-frame transfers' CRC, from its signature.
struct DataType {
  TransferKind kind;
  std::uint16_t id;
  std::uint64_t signature;
  std::uint16_t crc_seed = crc_of_signature(signature);
};

/// Sender, data type and receiver; destination 0 for messages, source 0 for anonymous ones.
struct Route {
  std::uint8_t priority;  ///< 0 highest … 31
  TransferKind kind;
  std::uint16_t type;
  std::uint8_t source;
  std::uint8_t destination;
};

std::uint32_t can_id_of(const Route& route);

/// nullopt for an id above 29 bits or a service from or to node 0.
std::optional<Route> route_of(std::uint32_t can_id);

/// Splits a payload into frames; returns their number, or 0 if `out` is too short.
[[nodiscard]] std::size_t split_transfer(const Route& route, const DataType& type,
                                         std::uint8_t transfer_id,
                                         std::span<const std::uint8_t> payload,
                                         std::span<CanFrame> out);

/// Reassembles transfers of any number of senders; when full, drops the one silent for longest.
class TransferReceiver {
 public:
  struct Transfer {
    Route route;
    std::uint8_t transfer_id;
    std::span<const std::uint8_t> payload;  ///< valid until the next call
  };

  /// The transfer that this frame completes, if any. `type` belongs to the frame's route.
  std::optional<Transfer> push(const Route& route, const DataType& type,
                               std::span<const std::uint8_t> frame, std::int64_t now_us,
                               Counters& counters);

 private:
  struct Session {
    std::uint32_t key = 0;  ///< 0: free
    std::uint8_t transfer_id = 0;
    bool toggle = false;
    std::uint8_t size = 0;
    std::int64_t last_us = 0;
    std::array<std::uint8_t, 64> buffer{};  ///< CRC and payload; longer transfers are not read
  };

  Session& session_of(std::uint32_t key);

  std::array<Session, 24> sessions_{};
};

}  // namespace flotilla::link
