// SPDX-License-Identifier: MIT
// A MAVLink link of the operating system, chosen by an address string in pymavlink's style.
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

  /// Sends whole messages, as one datagram if the link has datagrams. Messages that cannot be sent
  /// now are dropped whole.
  virtual void send(std::span<const std::uint8_t> messages) = 0;

  /// Copies received bytes; 0 if there are none.
  virtual std::size_t receive(std::span<std::uint8_t> out) = 0;

  /// Tells the link that the boat accepted a message in the bytes received last, signed or not.
  virtual void accepted(bool /*is_signed*/, std::int64_t /*now_us*/) {}

  /// Whether each receive() returns one datagram, with whole messages only.
  virtual bool datagrams() const = 0;

  /// For poll(); −1 while the device is gone.
  virtual int descriptor() const = 0;

  /// Opens the device if it is closed. May block: call it from a thread of its own.
  virtual void reopen() = 0;

  /// Takes over a device that reopen() opened, and forgets silent peers; call it at about 10 Hz.
  virtual void maintain(std::int64_t now_us) = 0;

  /// errno of the last attempt to open it.
  virtual int error() const = 0;
};

/// udpin:[HOST:]PORT   listens there, at 127.0.0.1 without HOST; sends to accepted peers, see Peers
/// udpout:HOST:PORT    exchanges messages with one peer only
/// udpbcast:HOST:PORT  sends to a broadcast address, receives from all that answer
/// serial:DEVICE:BAUD  a serial port, 8N1, raw; an absent one is opened when it appears
///
/// HOST is a numeric IPv4 address. Each is bound to one address of this machine; udpout and
/// udpbcast to the source address of the route to HOST. An absent address or port is no error:
/// reopen() opens it once it appears. Throws std::runtime_error that names a mistake of syntax.
std::unique_ptr<MavlinkEndpoint> open_mavlink_endpoint(std::string_view address);

/// Throws std::runtime_error if the address is malformed; opens nothing.
void require_mavlink_address(std::string_view address);

}  // namespace flotilla::target
