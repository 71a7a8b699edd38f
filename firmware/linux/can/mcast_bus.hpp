// SPDX-License-Identifier: MIT
// CAN frames in UDP multicast, as used by simulators and the DroneCAN GUI tool.
// Source: DroneCAN specification, chapter 4.2 "CAN bus over UDP multicast".
#pragma once

#include <netinet/in.h>

#include <optional>
#include <string>

#include "linux/can/can_bus.hpp"
#include "linux/system/file_descriptor.hpp"
#include "linux/system/reopened.hpp"

namespace flotilla::target {

/// Bus `bus` (0 … 9) is the group 239.65.82.bus, port 57732. Unlike CAN it has neither arbitration
/// nor back-pressure. One datagram is one frame, little endian:
///
///   u16 magic 0x2934 · u16 CRC-16-CCITT-FALSE of the rest · u16 flags · u32 id | 1 << 31 · data
class McastBus final : public CanBus {
 public:
  /// Without `interface` the frames stay on this machine (127.0.0.1, time to live 0).
  McastBus(unsigned bus, std::optional<in_addr> interface);

  void send(std::span<const link::CanFrame> frames) override;
  bool receive(link::CanFrame& frame) override;
  int descriptor() const override { return sockets_ ? sockets_->in.get() : -1; }
  void reopen() override;
  void maintain() override;
  bool usable() const override { return static_cast<bool>(sockets_); }
  std::string fault() const override;

 private:
  struct Sockets {
    FileDescriptor in, out;
    sockaddr_in own{};  ///< source address of our datagrams
  };

  int open(Sockets& fresh) const;  ///< 0 or errno
  bool write(const link::CanFrame& frame);

  sockaddr_in group_{};
  in_addr interface_{};
  int time_to_live_;
  Reopened<Sockets> sockets_;  ///< reopened if sending fails, except for a full queue
};

}  // namespace flotilla::target
