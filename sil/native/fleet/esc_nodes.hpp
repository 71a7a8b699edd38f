// SPDX-License-Identifier: MIT
// A boat's two ESCs: thrust only while armed, after a zero command, and while commands keep coming,
// as in AM32 firmware. Counterpart of sil/wire/esc_node.py in the live SIL. Both share a bus, so
// its frames are decoded once.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "fleet/clock.hpp"
#include "fleet/esc_receiver.hpp"
#include "fleet/fault.hpp"
#include "link/dronecan/can_frame.hpp"

namespace flotilla::fleet {

/// Port, starboard. Times are by the vessel's clock, µs.
class EscNodes {
 public:
  static constexpr std::size_t kEscs = 2;

  explicit EscNodes(std::array<std::uint8_t, kEscs> esc_indices);

  void on_can(std::uint32_t can_id, std::span<const std::uint8_t> data, std::int64_t now_us);

  /// A motor's present command, from full reverse −1 to full forward 1.
  double command(std::size_t esc, std::int64_t now_us) const;

  /// For both if `esc` is none.
  void set_fault(const Fault& fault, std::int64_t now_us);
  void clear_fault(FaultKind kind, std::optional<std::size_t> esc);

  using Frames = std::vector<link::CanFrame>;

  /// Appends the frames due, in order, to `out`; rpm (1/min) of the two shafts.
  void tick(std::int64_t now_us, const double* rpm, Frames& out);

 private:
  struct Esc {
    std::uint8_t index;
    std::int16_t raw = 0;
    bool zero_seen = false;
    std::int64_t raw_us = kNever_us, armed_us = kNever_us, boot_us = kNever_us;
    std::uint8_t node_status_id = 0, esc_status_id = 0;
    // active faults
    bool silent = false, reversed = false, off = false;
    std::optional<double> stuck{};     // at this command
    std::optional<float> voltage_V{};  // as reported
  };
  struct PendingRequest {
    std::size_t esc;
    std::uint8_t source, priority, transfer_id;
  };
  static constexpr std::int64_t kNever_us = -(std::int64_t{1} << 62);

  void take_raw_command(const EscReceiver::Transfer& transfer, std::int64_t now_us);
  void tell_node_status(std::size_t esc, std::int64_t now_us, Frames& out);
  void tell_esc_status(std::size_t esc, std::int64_t now_us, double rpm, Frames& out);
  void answer(const PendingRequest& request, std::int64_t now_us, Frames& out) const;
  double told(const Esc& esc, std::int64_t now_us) const;

  std::array<Esc, kEscs> escs_;
  EscReceiver receiver_;
  std::vector<PendingRequest> pending_;
  Rate node_status_rate_, esc_status_rate_;
};

}  // namespace flotilla::fleet
