// SPDX-License-Identifier: MIT
// Listens on a boat's CAN bus, to received and sent frames.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "link/dronecan/can_frame.hpp"
#include "link/dronecan/transfer.hpp"
#include "policies/moment.hpp"

namespace flotilla::policies {

class CanEar {
 public:
  explicit CanEar(std::uint8_t node) : node_(node) {}

  /// A frame that the boat receives.
  void hear(std::uint32_t can_id, std::span<const std::uint8_t> data, const app::Parameters& p,
            Heard& heard);

  /// All frames that the boat sends in a tick, into n.bus and longer-lived fields.
  void read(std::span<const link::CanFrame> frames, const app::Parameters& p, Moment& n);

 private:
  struct Esc {
    std::uint8_t node = 0;
    bool counts = false;  ///< its uptime is known
    std::uint32_t uptime_s = 0;
  };
  /// An incomplete multi-frame transfer.
  struct Part {
    std::uint32_t id = 0;
    std::uint8_t tail = 0;
    std::size_t size = 0;  ///< 0: none
    std::array<std::uint8_t, 140> bytes;
  };
  struct Next {
    bool known = false;
    std::uint8_t id = 0;
  };

  void hear_esc(std::uint8_t node, std::span<const std::uint8_t> data, const app::Parameters& p,
                Heard& heard);
  void hear_node(std::uint8_t node, std::span<const std::uint8_t> data, Heard& heard);
  bool join(const link::CanFrame& frame, Part& part) const;
  void take(std::uint32_t can_id, std::uint8_t transfer_id, std::span<const std::uint8_t> payload,
            const app::Parameters& p, Moment& n);
  static bool counts_on(Next& next, std::uint8_t transfer_id);

  std::uint8_t node_;
  std::array<Esc, 2> escs_{};
  Next command_, arming_, status_;
};

}  // namespace flotilla::policies
