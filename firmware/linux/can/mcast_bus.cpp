// SPDX-License-Identifier: MIT
#include "linux/can/mcast_bus.hpp"

#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "link/dronecan/crc16.hpp"

namespace flotilla::target {
namespace {

constexpr std::uint32_t kGroups = 0xEF415200;  // 239.65.82.0
constexpr std::uint16_t kPort = 57732, kMagic = 0x2934, kFlagFd = 1;
constexpr std::uint32_t kExtended = 1U << 31U, kGreatestId = (1U << 29U) - 1;
constexpr std::size_t kCrcAt = 2, kFlagsAt = 4, kIdAt = 6, kDataAt = 10, kLongest = kDataAt + 8;

using Packet = std::array<std::uint8_t, kLongest>;

std::uint16_t crc_of(std::span<const std::uint8_t> bytes) {
  return link::crc16(link::kCrc16Start, bytes);
}

template <class Integer>
void put(std::span<std::uint8_t> bytes, std::size_t at, Integer value) {
  for (std::size_t i = 0; i < sizeof value; ++i) {
    bytes[at + i] = static_cast<std::uint8_t>(value >> (8U * i));
  }
}

template <class Integer>
Integer get(std::span<const std::uint8_t> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < sizeof(Integer); ++i) {
    value |= std::uint32_t{bytes[at + i]} << (8U * i);
  }
  return static_cast<Integer>(value);
}

/// Returns the packet's length.
std::size_t pack(const link::CanFrame& frame, Packet& packet) {
  put(packet, 0, kMagic);
  put(packet, kFlagsAt, std::uint16_t{0});
  put(packet, kIdAt, frame.id | kExtended);
  std::ranges::copy(frame.bytes(), packet.begin() + kDataAt);
  const std::size_t size = kDataAt + frame.size;
  put(packet, kCrcAt, crc_of(std::span(packet).first(size).subspan(kFlagsAt)));
  return size;
}

/// False unless the packet is a classic CAN frame with a 29-bit id.
bool unpack(std::span<const std::uint8_t> packet, link::CanFrame& frame) {
  if (packet.size() < kDataAt || packet.size() > kLongest) return false;
  if (get<std::uint16_t>(packet, 0) != kMagic) return false;
  if (get<std::uint16_t>(packet, kCrcAt) != crc_of(packet.subspan(kFlagsAt))) return false;
  if ((get<std::uint16_t>(packet, kFlagsAt) & kFlagFd) != 0) return false;
  const std::uint32_t id = get<std::uint32_t>(packet, kIdAt) ^ kExtended;
  if (id > kGreatestId) return false;
  const auto data = packet.subspan(kDataAt);
  frame = {id, static_cast<std::uint8_t>(data.size()), {}};
  std::ranges::copy(data, frame.data.begin());
  return true;
}

template <class Value>
bool set_option(const FileDescriptor& socket, int level, int name, const Value& value) {
  return ::setsockopt(socket.get(), level, name, &value, sizeof value) == 0;
}

const sockaddr* generic(const sockaddr_in& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

FileDescriptor udp_socket() {
  return FileDescriptor(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
}

}  // namespace

McastBus::McastBus(unsigned bus, std::optional<in_addr> interface)
    : time_to_live_(interface ? 1 : 0) {
  group_.sin_family = AF_INET;
  group_.sin_port = htons(kPort);
  group_.sin_addr.s_addr = htonl(kGroups | bus);
  interface_ = interface.value_or(in_addr{htonl(INADDR_LOOPBACK)});
  reopen();
  sockets_.take();
}

void McastBus::reopen() {
  sockets_.reopen([this](Sockets& fresh) { return open(fresh); });
}

std::string McastBus::fault() const {
  if (sockets_.error() == EADDRNOTAVAIL) return "no interface of this machine has that address";
  return sockets_.error() == 0 ? std::string() : std::strerror(sockets_.error());
}

int McastBus::open(Sockets& fresh) const {
  // `in` is bound to the group: INADDR_ANY would also receive the other buses on this port.
  FileDescriptor in = udp_socket();
  FileDescriptor out = udp_socket();
  const ip_mreqn membership{group_.sin_addr, interface_, 0};
  sockaddr_in from{};
  from.sin_family = AF_INET;
  from.sin_addr = interface_;
  sockaddr_in own{};
  socklen_t size = sizeof own;
  const bool done = in && out &&
                    // Bind `out` first, which checks that the interface's address is ours.
                    ::bind(out.get(), generic(from), sizeof from) == 0 &&
                    set_option(out, IPPROTO_IP, IP_MULTICAST_IF, membership) &&
                    set_option(out, IPPROTO_IP, IP_MULTICAST_TTL, time_to_live_) &&
                    ::connect(out.get(), generic(group_), sizeof group_) == 0 &&
                    set_option(in, SOL_SOCKET, SO_REUSEADDR, 1) &&
                    set_option(in, SOL_SOCKET, SO_RXQ_OVFL, 1) &&
                    // Otherwise groups joined by other programs arrive too.
                    set_option(in, IPPROTO_IP, IP_MULTICAST_ALL, 0) &&
                    ::bind(in.get(), generic(group_), sizeof group_) == 0 &&
                    set_option(in, IPPROTO_IP, IP_ADD_MEMBERSHIP, membership) &&
                    ::getsockname(out.get(), reinterpret_cast<sockaddr*>(&own), &size) == 0;
  if (!done) return errno;
  fresh = {std::move(in), std::move(out), own};
  return 0;
}

void McastBus::maintain() {
  if (!sockets_.take()) return;
  overflows_seen_ = 0;
  ++counters_.reopened;
}

void McastBus::send(std::span<const link::CanFrame> frames) {
  while (!frames.empty()) {
    const auto transfer = first_transfer(frames);
    frames = frames.subspan(transfer.size());
    const auto sent = [this](const link::CanFrame& frame) { return write(frame); };
    if (!std::ranges::all_of(transfer, sent)) ++counters_.transfers_dropped;
  }
}

bool McastBus::write(const link::CanFrame& frame) {
  if (!sockets_) return false;
  Packet packet{};
  const std::size_t size = pack(frame, packet);
  const bool sent = ::send(sockets_->out.get(), packet.data(), size, 0) >= 0;
  if (!sent && errno != EAGAIN && errno != ENOBUFS) sockets_.give_up();
  if (sent) ++counters_.sent;
  return sent;
}

bool McastBus::receive(link::CanFrame& frame) {
  while (sockets_) {
    std::array<std::uint8_t, kLongest + 1> packet{};  // one more byte, to detect longer packets
    sockaddr_in from{};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(std::uint32_t))> control{};
    iovec part{packet.data(), packet.size()};
    msghdr message{};
    message.msg_name = &from;
    message.msg_namelen = sizeof from;
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    const ssize_t size = ::recvmsg(sockets_->in.get(), &message, MSG_DONTWAIT);
    if (size < 0) return false;
    count_overflows(message);
    if (from.sin_port == sockets_->own.sin_port &&
        from.sin_addr.s_addr == sockets_->own.sin_addr.s_addr)
      continue;
    if (unpack(std::span(packet).first(static_cast<std::size_t>(size)), frame)) {
      ++counters_.received;
      return true;
    }
    ++counters_.bad_packets;
  }
  return false;
}

}  // namespace flotilla::target
