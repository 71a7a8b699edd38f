// SPDX-License-Identifier: MIT
// Reassembles DroneCAN transfers as ESCs do: every frame in order, from any number of senders.
// Counterpart of Receiver in sil/wire/dronecan_transfer.py in the live SIL.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

namespace flotilla::fleet {

class EscReceiver {
 public:
  /// A complete transfer. Only its first bytes are kept: no message that an ESC reads is longer.
  struct Transfer {
    std::size_t size;
    std::span<const std::uint8_t> first;  ///< valid until the next call
  };

  /// Takes a frame of a type that ESCs read, not anonymous; `crc_seed`: of its data type.
  std::optional<Transfer> push(std::uint32_t can_id, std::span<const std::uint8_t> data,
                               std::uint16_t crc_seed, std::int64_t now_us);

 private:
  struct Session {
    std::uint32_t key;
    std::uint8_t transfer_id = 0;
    std::uint8_t toggle = 0;
    bool open = false;
    std::int64_t start_us = -(std::int64_t{1} << 62);
    std::uint16_t crc_told = 0, crc = 0;
    std::uint16_t size = 0;  // with the checksum
    std::array<std::uint8_t, 36> first{};

    void restart(unsigned id);
    void append(std::span<const std::uint8_t> payload, std::uint16_t crc_seed);
  };

  Session& session_of(std::uint32_t key);

  std::vector<Session> sessions_;
};

}  // namespace flotilla::fleet
