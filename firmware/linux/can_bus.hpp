// SPDX-License-Identifier: MIT
// A CAN bus of the operating system, chosen by a string.
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

/// What happened on a bus since it was opened.
struct CanBusCounters {
  std::uint64_t sent = 0;               ///< frames
  std::uint64_t received = 0;           ///< frames for us
  std::uint64_t transfers_dropped = 0;  ///< whole transfers that found no room in the queue
  std::uint64_t receive_overflows = 0;  ///< frames that the kernel dropped before we read them
  std::uint64_t error_frames = 0;
  std::uint64_t bus_off = 0;      ///< times
  std::uint64_t reopened = 0;     ///< times, also for a device that came after the start
  std::uint64_t bad_packets = 0;  ///< datagrams that are no classic CAN frame with a 29-bit id
};

/// One bus. Nothing here blocks, sleeps or throws after construction.
class CanBus {
 public:
  virtual ~CanBus() = default;

  /// Sends transfers, frame after frame. A transfer of which one frame finds no room is dropped
  /// whole as far as it is not on its way already; so is every transfer while the bus is not usable.
  virtual void send(std::span<const link::CanFrame> frames) = 0;

  /// The next frame that has arrived; false where there is none.
  virtual bool receive(link::CanFrame& frame) = 0;

  /// To wait for with poll(); −1 while there is none (the device is gone).
  virtual int descriptor() const = 0;

  /// Opens the device again where it vanished, notices that a bus works again; called about ten
  /// times a second.
  virtual void maintain() = 0;

  /// The interface is up and not bus-off. However short a bus-off was, this is false from the
  /// receive() that read of it to the next maintain().
  virtual bool usable() const = 0;

  const CanBusCounters& counters() const { return counters_; }

 protected:
  /// Adds up what the kernel says (SO_RXQ_OVFL) with a received message about those before it.
  void count_overflows(msghdr& message);

  CanBusCounters counters_;
  std::uint32_t overflows_seen_ = 0;  ///< of the open socket, as last said
};

/// The frames up to and including the first that ends a transfer (bit 6 of its tail byte).
std::span<const link::CanFrame> first_transfer(std::span<const link::CanFrame> frames);

/// `socketcan:can0` or `mcast:N[:ADDRESS]`. `node`: our DroneCAN node id, for the kernel's filter.
/// Throws std::runtime_error that says what is wrong with the address, or that this kernel has no
/// AF_CAN. A CAN interface that is down or does not exist yet is no error: it is opened when it
/// comes. ADDRESS is an IPv4 address of this machine; with it frames may leave the machine.
std::unique_ptr<CanBus> open_can_bus(std::string_view address, std::uint8_t node);

}  // namespace flotilla::target
