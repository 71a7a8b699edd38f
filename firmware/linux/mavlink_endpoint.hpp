// SPDX-License-Identifier: MIT
// A MAVLink link of the operating system, chosen by the address strings that pymavlink users know.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

namespace flotilla::target {

/// One link. Nothing here blocks, sleeps or throws after construction.
class MavlinkEndpoint {
 public:
  virtual ~MavlinkEndpoint() = default;

  /// Sends whole messages, as one datagram where there are datagrams. What cannot be sent now is
  /// dropped whole and counted.
  virtual void send(std::span<const std::uint8_t> messages) = 0;

  /// Bytes that have arrived; 0 where there are none.
  virtual std::size_t receive(std::span<std::uint8_t> out) = 0;

  /// What receive() returns at a time is a datagram: messages begin and end with it.
  virtual bool datagrams() const = 0;

  /// To wait for with poll(); −1 while there is none (the device is gone).
  virtual int descriptor() const = 0;

  /// Opens a device that vanished again; called about ten times a second.
  virtual void maintain() = 0;

  std::uint64_t dropped() const { return dropped_; }

 protected:
  std::uint64_t dropped_ = 0;  ///< calls of send() whose bytes could not be sent
};

/// udpin:[HOST:]PORT   waits there, at 127.0.0.1 without HOST; answers all who have talked to it
/// udpout:HOST:PORT    talks to one, and hears nobody else
/// udpbcast:HOST:PORT  talks to a broadcast address, and hears whoever answers
/// serial:DEVICE:BAUD  a serial port, 8N1, raw; one that is absent is opened when it comes
///
/// HOST is a numeric IPv4 address. Each is bound to one address of this machine, all but udpin's to
/// the one where the way to HOST begins; a way that comes later is waited for. Throws std::runtime_error that says what is wrong.
std::unique_ptr<MavlinkEndpoint> open_mavlink_endpoint(std::string_view address);

}  // namespace flotilla::target
