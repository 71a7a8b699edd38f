// SPDX-License-Identifier: MIT
// UDP to a fixed peer (udpout, udpbcast), or to the senders of accepted messages (udpin).
#pragma once

#include <netinet/in.h>

#include "linux/mavlink/endpoint_address.hpp"
#include "linux/mavlink/mavlink_endpoint.hpp"
#include "linux/mavlink/peers.hpp"
#include "linux/system/file_descriptor.hpp"
#include "linux/system/reopened.hpp"

namespace flotilla::target {

/// Bound to one address of this machine: the named one, or the source address of the route to the
/// peer. Reopened when the network comes up late or this machine's address changes.
class UdpEndpoint final : public MavlinkEndpoint {
 public:
  explicit UdpEndpoint(const EndpointAddress& address);

  void send(std::span<const std::uint8_t> messages) override;
  std::size_t receive(std::span<std::uint8_t> out) override;
  void accepted(bool is_signed, std::int64_t now_us) override;
  bool datagrams() const override { return true; }
  int descriptor() const override { return socket_ ? socket_->get() : -1; }
  void reopen() override;
  void maintain(std::int64_t now_us) override;
  int error() const override { return socket_.error(); }

 private:
  int open(FileDescriptor& fresh) const;  ///< 0 or errno
  void send_to(const sockaddr_in& peer, std::span<const std::uint8_t> messages);

  bool learns_, broadcasts_;
  sockaddr_in named_{};
  Reopened<FileDescriptor> socket_;
  Peers peers_;
  sockaddr_in from_{};  // of the last datagram
};

}  // namespace flotilla::target
