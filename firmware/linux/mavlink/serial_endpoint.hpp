// SPDX-License-Identifier: MIT
// A serial port: a byte stream, 8N1.
#pragma once

#include <termios.h>

#include <string>
#include <vector>

#include "linux/mavlink/endpoint_address.hpp"
#include "linux/mavlink/mavlink_endpoint.hpp"
#include "linux/system/file_descriptor.hpp"
#include "linux/system/reopened.hpp"

namespace flotilla::target {

/// Bytes that the port cannot take at once wait. Until they are sent, the output of each later tick
/// is dropped whole, so that no message is cut.
class SerialEndpoint final : public MavlinkEndpoint {
 public:
  explicit SerialEndpoint(const EndpointAddress& address);

  void send(std::span<const std::uint8_t> messages) override;
  std::size_t receive(std::span<std::uint8_t> out) override;
  bool datagrams() const override { return false; }
  int descriptor() const override { return port_ ? port_->get() : -1; }
  void reopen() override;
  void maintain(std::int64_t now_us) override;
  int error() const override { return port_.error(); }

 private:
  int open(FileDescriptor& fresh) const;  ///< 0 or errno
  void flush();

  std::string device_;
  speed_t speed_ = B57600;
  Reopened<FileDescriptor> port_;
  std::vector<std::uint8_t> waiting_;
};

}  // namespace flotilla::target
