// SPDX-License-Identifier: MIT
#include "linux/can/socketcan_bus.hpp"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <linux/sock_diag.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "link/dronecan/messages.hpp"

namespace flotilla::target {
namespace {

constexpr canid_t kService = 0x80, kSource = 0x7F, kDestination = 0x7F00, kMessageType = 0xFFFF00;
constexpr canid_t kAnonymousType = 0x300;  // bits above it are random
constexpr canid_t kKind = CAN_EFF_FLAG | CAN_RTR_FLAG;

/// About 32 frames, whatever the interface's txqueuelen: outdated commands are of no use.
constexpr int kSendBuffer_bytes = 12 * 1024;

can_filter message_filter(const link::DataType& type) {
  return {CAN_EFF_FLAG | canid_t{type.id} << 8U, kKind | kMessageType | kService};
}

/// Filters for the transfers that a boat reads.
std::array<can_filter, 10> filters_of(std::uint8_t node) {
  return {{message_filter(link::EscStatus::kType),
           message_filter(link::NodeStatus::kType),
           message_filter(link::RawCommand::kType),
           message_filter(link::RpmCommand::kType),
           message_filter(link::ArmingStatus::kType),
           message_filter(link::SafetyState::kType),
           message_filter(link::Button::kType),
           message_filter(link::Allocation::kType),
           {CAN_EFF_FLAG | canid_t{link::Allocation::kType.id} << 8U,
            kKind | kAnonymousType | kService | kSource},
           {CAN_EFF_FLAG | kService | canid_t{node} << 8U, kKind | kService | kDestination}}};
}

ifreq request_about(const std::string& interface) {
  ifreq request{};
  interface.copy(request.ifr_name, IFNAMSIZ - 1);
  return request;
}

template <class Value>
bool set_option(int socket, int level, int name, const Value& value) {
  return ::setsockopt(socket, level, name, &value, sizeof value) == 0;
}

bool set_options(int socket, std::uint8_t node) {
  return set_option(socket, SOL_CAN_RAW, CAN_RAW_FILTER, filters_of(node)) &&
         set_option(socket, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, can_err_mask_t{CAN_ERR_MASK}) &&
         set_option(socket, SOL_CAN_RAW, CAN_RAW_LOOPBACK, 1) &&
         set_option(socket, SOL_CAN_RAW, CAN_RAW_RECV_OWN_MSGS, 0) &&
         set_option(socket, SOL_SOCKET, SO_SNDBUF, kSendBuffer_bytes) &&
         set_option(socket, SOL_SOCKET, SO_RXQ_OVFL, 1);
}

std::string why(int error) {
  switch (error) {
    case EAFNOSUPPORT:
    case EPROTONOSUPPORT:
      return "this kernel has no AF_CAN (modules can and can-raw; tools/with-vcan for tests)";
    case EMEDIUMTYPE:
      return "not a CAN interface";
    case ENODEV:
      return "no such interface";
    default:
      return error == 0 ? std::string() : std::strerror(error);
  }
}

}  // namespace

SocketCanBus::SocketCanBus(std::string interface, std::uint8_t node)
    : interface_(std::move(interface)), node_(node) {
  reopen();
  take();
}

void SocketCanBus::reopen() {
  socket_.reopen([this](FileDescriptor& fresh) { return open(fresh); });
}

std::string SocketCanBus::fault() const { return why(socket_.error()); }

int SocketCanBus::open(FileDescriptor& fresh) const {
  FileDescriptor socket(::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW));
  if (!socket) return errno;
  ifreq request = request_about(interface_);
  if (::ioctl(socket.get(), SIOCGIFHWADDR, &request) != 0) return errno;
  if (request.ifr_hwaddr.sa_family != ARPHRD_CAN) return EMEDIUMTYPE;
  if (::ioctl(socket.get(), SIOCGIFINDEX, &request) != 0) return errno;
  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = request.ifr_ifindex;
  if (!set_options(socket.get(), node_) ||
      ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return errno;
  }
  fresh = std::move(socket);
  return 0;
}

bool SocketCanBus::take() {
  if (!socket_.take()) return false;
  overflows_seen_ = 0;
  controller_ = Controller::kOn;
  flushing_ = false;
  running_ = running(false);
  return true;
}

void SocketCanBus::close() {
  socket_.give_up();
  running_ = false;
}

/// Whether the kernel reports the interface as running (a bus-off controller has no carrier);
/// `before` if the kernel cannot be asked.
bool SocketCanBus::running(bool before) {
  ifreq request = request_about(interface_);
  if (::ioctl(socket_->get(), SIOCGIFFLAGS, &request) != 0) {
    on_failure(errno);
    return before && static_cast<bool>(socket_);
  }
  constexpr int kBoth = IFF_UP | IFF_RUNNING;
  return (request.ifr_flags & kBoth) == kBoth;
}

void SocketCanBus::maintain() {
  if (!socket_) {
    if (take()) ++counters_.reopened;
    return;
  }
  const bool ran = std::exchange(running_, running(running_));
  if (running_ && !ran) {  // the controller has restarted
    controller_ = Controller::kOn;
    flushing_ = true;
  } else if (controller_ == Controller::kOff) {
    controller_ = Controller::kStillOff;
  } else if (controller_ == Controller::kRecovered) {
    controller_ = Controller::kOn;
  }
}

bool SocketCanBus::usable() const { return socket_ && running_ && controller_ == Controller::kOn; }

void SocketCanBus::send(std::span<const link::CanFrame> frames) {
  const bool fresh = usable() && flushed();
  while (!frames.empty()) {
    const auto transfer = first_transfer(frames);
    frames = frames.subspan(transfer.size());
    const auto sent = [this](const link::CanFrame& frame) { return write(frame); };
    if (!fresh || !std::ranges::all_of(transfer, sent)) ++counters_.transfers_dropped;
  }
}

bool SocketCanBus::flushed() {
  if (!flushing_) return true;
  std::array<std::uint32_t, SK_MEMINFO_VARS> memory{};
  socklen_t size = sizeof memory;
  const int error = ::getsockopt(socket_->get(), SOL_SOCKET, SO_MEMINFO, memory.data(), &size);
  flushing_ = error == 0 && memory[SK_MEMINFO_WMEM_ALLOC] != 0;
  return !flushing_;
}

bool SocketCanBus::write(const link::CanFrame& frame) {
  if (!socket_) return false;
  ::can_frame out{};
  out.can_id = frame.id | CAN_EFF_FLAG;
  out.len = frame.size;
  std::ranges::copy(frame.bytes(), out.data);
  if (::write(socket_->get(), &out, sizeof out) != sizeof out) {
    on_failure(errno);
    return false;
  }
  ++counters_.sent;
  return true;
}

bool SocketCanBus::receive(link::CanFrame& frame) {
  while (socket_) {
    ::can_frame in{};
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(std::uint32_t))> control{};
    iovec part{&in, sizeof in};
    msghdr message{};
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    message.msg_control = control.data();
    message.msg_controllen = control.size();
    if (::recvmsg(socket_->get(), &message, MSG_DONTWAIT) < 0) {
      on_failure(errno);
      return false;
    }
    count_overflows(message);
    if ((in.can_id & CAN_ERR_FLAG) != 0) {
      on_error_frame(in);
      continue;
    }
    if (controller_ == Controller::kStillOff) controller_ = Controller::kRecovered;
    frame.id = in.can_id & CAN_EFF_MASK;
    frame.size = std::min<std::uint8_t>(in.len, CAN_MAX_DLEN);
    std::copy_n(in.data, CAN_MAX_DLEN, frame.data.begin());
    ++counters_.received;
    return true;
  }
  return false;
}

void SocketCanBus::on_error_frame(const ::can_frame& frame) {
  ++counters_.error_frames;
  if ((frame.can_id & CAN_ERR_BUSOFF) != 0) {
    if (controller_ == Controller::kOn || controller_ == Controller::kRecovered) {
      ++counters_.bus_off;
    }
    controller_ = Controller::kOff;
    flushing_ = true;
  }
  if ((frame.can_id & CAN_ERR_RESTARTED) != 0 && controller_ != Controller::kOn) {
    controller_ = Controller::kRecovered;
  }
}

/// Handles a failed call. A full queue (ENOBUFS, EAGAIN) or an empty one changes nothing.
void SocketCanBus::on_failure(int error) {
  if (error == ENETDOWN) running_ = false;
  if (error == ENODEV || error == ENXIO) close();
}

}  // namespace flotilla::target
