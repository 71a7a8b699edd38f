// SPDX-License-Identifier: MIT
// CAN frames in UDP multicast, as used by simulators and the DroneCAN GUI tool.
// Source: DroneCAN specification, chapter 4.2 "CAN bus over UDP multicast".
#pragma once

#include <netinet/in.h>

#include <optional>

#include "linux/can/can_bus.hpp"
#include "linux/system/file_descriptor.hpp"

namespace flotilla::target {

/// Bus `bus` (0 … 9) is the group 239.65.82.bus, port 57732. Unlike CAN it has neither arbitration
/// nor back-pressure. One datagram is one frame, little endian:
///
///   u16 magic 0x2934 · u16 CRC-16-CCITT-FALSE of the rest · u16 flags · u32 id | 1 << 31 · data
class McastBus final : public CanBus {
 public:
  /// Without `interface` the frames stay on this machine (127.0.0.1, time to live 0). Throws
  /// std::system_error, for example if no interface of this machine has that address.
  McastBus(unsigned bus, std::optional<in_addr> interface);

  void send(std::span<const link::CanFrame> frames) override;
  bool receive(link::CanFrame& frame) override;
  int descriptor() const override { return in_.get(); }
  void maintain() override;
  bool usable() const override { return !failed_; }

 private:
  int open();  ///< 0 or errno
  bool write(const link::CanFrame& frame);

  sockaddr_in group_{};
  in_addr interface_{};
  int time_to_live_;
  FileDescriptor in_, out_;
  sockaddr_in own_{};    ///< source address of our datagrams
  bool failed_ = false;  ///< the last datagram failed for a reason other than a full queue
};

}  // namespace flotilla::target
