// SPDX-License-Identifier: MIT
// A CAN bus of the operating system, selected by an address string.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "link/dronecan/can_frame.hpp"

struct msghdr;

namespace flotilla::target {

/// Counters since the bus was opened.
struct CanBusCounters {
  std::uint64_t sent = 0;               ///< frames
  std::uint64_t received = 0;           ///< frames
  std::uint64_t transfers_dropped = 0;  ///< transfers not sent completely
  std::uint64_t receive_overflows = 0;  ///< frames that the kernel dropped before we read them
  std::uint64_t error_frames = 0;
  std::uint64_t bus_off = 0;      ///< bus-offs
  std::uint64_t reopened = 0;     ///< reopenings, also of a device that appeared after the start
  std::uint64_t bad_packets = 0;  ///< datagrams other than a classic CAN frame with a 29-bit id
};

/// One bus. Nothing here blocks, sleeps or throws after construction.
class CanBus {
 public:
  virtual ~CanBus() = default;

  /// Sends transfers, frame after frame. If there is no room for a frame, drops it and the rest of
  /// its transfer; while the bus is not usable, drops all transfers.
  virtual void send(std::span<const link::CanFrame> frames) = 0;

  /// The next received frame; false if there is none.
  virtual bool receive(link::CanFrame& frame) = 0;

  /// For poll(); −1 while the device is gone.
  virtual int descriptor() const = 0;

  /// Opens the device if it is closed. May block: call it from a thread of its own.
  virtual void reopen() = 0;

  /// Takes over a device that reopen() opened, and detects a recovered bus; call it at about 10 Hz.
  virtual void maintain() = 0;

  /// Why the device could not be opened; empty if it could.
  virtual std::string fault() const = 0;

  /// The interface is up and not bus-off. After a bus-off, however short, it is false from the
  /// receive() that reports the bus-off until the next maintain().
  virtual bool usable() const = 0;

  const CanBusCounters& counters() const { return counters_; }

 protected:
  /// Adds the kernel's overflow count (SO_RXQ_OVFL), received with a message.
  void count_overflows(msghdr& message);

  CanBusCounters counters_;
  std::uint32_t overflows_seen_ = 0;  ///< last count of the open socket
};

/// The frames up to and including the first that ends a transfer (bit 6 of its tail byte).
std::span<const link::CanFrame> first_transfer(std::span<const link::CanFrame> frames);

/// `address`: socketcan:can0 or mcast:N[:ADDRESS]. ADDRESS is an IPv4 address of this machine; only
/// with it may multicast frames leave the machine. `node`: our DroneCAN node id, for the kernel's
/// filter. Throws std::runtime_error if the address is malformed. A device that is down or absent
/// is no error: reopen() opens it once it appears.
std::unique_ptr<CanBus> open_can_bus(std::string_view address, std::uint8_t node);

/// Throws std::runtime_error if the address is malformed; opens nothing.
void require_can_address(std::string_view address);

}  // namespace flotilla::target
