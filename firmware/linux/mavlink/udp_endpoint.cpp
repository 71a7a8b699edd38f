// SPDX-License-Identifier: MIT
#include "linux/mavlink/udp_endpoint.hpp"

#include <arpa/inet.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

namespace flotilla::target {
namespace {

const sockaddr* generic(const sockaddr_in& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

FileDescriptor udp_socket() {
  FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int yes = 1;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_BROADCAST, &yes, sizeof yes);
  return socket;
}

}  // namespace

sockaddr_in socket_address_of(const EndpointAddress& address) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(static_cast<std::uint16_t>(number_of(address, 65535)));
  if (::inet_pton(AF_INET, address.place.c_str(), &out.sin_addr) != 1) {
    refuse(address.whole, "\"" + address.place + "\" is not a numeric IPv4 address");
  }
  return out;
}

UdpEndpoint::UdpEndpoint(const EndpointAddress& address)
    : learns_(address.scheme == "udpin"),
      broadcasts_(address.scheme == "udpbcast"),
      named_(socket_address_of(address)) {
  reopen();
  socket_.take();
}

int UdpEndpoint::open(FileDescriptor& fresh) const {
  FileDescriptor socket = udp_socket();
  sockaddr_in own = named_;
  if (!learns_) {
    socklen_t length = sizeof own;
    if (::connect(socket.get(), generic(named_), sizeof named_) != 0 ||
        ::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&own), &length) != 0) {
      return errno;
    }
    own.sin_port = 0;
  }
  // A connected socket would not receive answers to a broadcast.
  if (broadcasts_) socket = udp_socket();
  const bool bound = !learns_ && !broadcasts_;
  if (!bound && ::bind(socket.get(), generic(own), sizeof own) != 0) return errno;
  fresh = std::move(socket);
  return 0;
}

void UdpEndpoint::reopen() {
  socket_.reopen([this](FileDescriptor& fresh) { return open(fresh); });
}

void UdpEndpoint::maintain(std::int64_t now_us) {
  peers_.forget_silent(now_us);
  socket_.take();
}

void UdpEndpoint::send(std::span<const std::uint8_t> messages) {
  if (!learns_) return send_to(named_, messages);
  for (const Peers::Peer& peer : peers_.all()) send_to(peer.address, messages);
}

void UdpEndpoint::send_to(const sockaddr_in& peer, std::span<const std::uint8_t> messages) {
  if (!socket_) return;
  const ssize_t sent = ::sendto(socket_->get(), messages.data(), messages.size(), MSG_NOSIGNAL,
                                generic(peer), sizeof peer);
  // ECONNREFUSED: nobody listens there yet; MAVLink messages repeat.
  if (sent >= 0 || errno == ECONNREFUSED) return;
  // Temporary failures: a new socket would not help, and would change our source address.
  constexpr std::array kPassing{EAGAIN, ENOBUFS, EHOSTUNREACH, EPERM};
  if (!learns_ && std::ranges::find(kPassing, errno) == kPassing.end()) socket_.give_up();
}

std::size_t UdpEndpoint::receive(std::span<std::uint8_t> out) {
  if (!socket_) return 0;
  socklen_t length = sizeof from_;
  const ssize_t size = ::recvfrom(socket_->get(), out.data(), out.size(), 0,
                                  reinterpret_cast<sockaddr*>(&from_), &length);
  return size > 0 ? static_cast<std::size_t>(size) : 0;
}

void UdpEndpoint::accepted(bool is_signed, std::int64_t now_us) {
  if (learns_) peers_.accepted(from_, is_signed, now_us);
}

}  // namespace flotilla::target
