// SPDX-License-Identifier: MIT
#include "linux/mavlink/mavlink_endpoint.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <termios.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "linux/mavlink/peers.hpp"
#include "linux/system/file_descriptor.hpp"

namespace flotilla::target {
namespace {

[[noreturn]] void refuse(std::string_view address, const std::string& why) {
  throw std::runtime_error("MAVLink link \"" + std::string(address) + "\": " + why);
}

constexpr const char* kLoopback = "127.0.0.1";

struct Address {
  std::string scheme, place, number;
};

/// "a:b:c"; the middle part may contain colons. "udpin:c" stays on this machine.
Address split(std::string_view address) {
  const std::size_t first = address.find(':'), last = address.rfind(':');
  if (first == last && address.starts_with("udpin:")) {
    return {"udpin", kLoopback, std::string(address.substr(first + 1))};
  }
  if (first == std::string_view::npos || first == last) {
    refuse(address,
           "must be udpin:[HOST:]PORT, udpout:HOST:PORT, udpbcast:HOST:PORT or serial:DEVICE:BAUD");
  }
  return {std::string(address.substr(0, first)),
          std::string(address.substr(first + 1, last - first - 1)),
          std::string(address.substr(last + 1))};
}

unsigned number_of(std::string_view address, const std::string& text, unsigned greatest) {
  unsigned value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || value == 0 || value > greatest) {
    refuse(address, "\"" + text + "\" is no number from 1 to " + std::to_string(greatest));
  }
  return value;
}

const sockaddr* generic(const sockaddr_in& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

FileDescriptor udp_socket() {
  FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int yes = 1;
  ::setsockopt(socket.get(), SOL_SOCKET, SO_BROADCAST, &yes, sizeof yes);
  return socket;
}

/// UDP to a fixed peer (udpout, udpbcast), or to those of whom a message was accepted (udpin). Bound
/// to one address of this machine: the named one, or the source address of the route to the peer.
class UdpEndpoint final : public MavlinkEndpoint {
 public:
  UdpEndpoint(std::string_view address, const Address& parts)
      : learns_(parts.scheme == "udpin"), broadcasts_(parts.scheme == "udpbcast") {
    named_.sin_family = AF_INET;
    named_.sin_port = htons(static_cast<std::uint16_t>(number_of(address, parts.number, 65535)));
    if (::inet_pton(AF_INET, parts.place.c_str(), &named_.sin_addr) != 1) {
      refuse(address, "\"" + parts.place + "\" is no numeric IPv4 address");
    }
    const int error = open();
    lost_ = error != 0;
    if (learns_ && lost_) {
      refuse(address, std::string("cannot listen there: ") + std::strerror(error));
    }
    if (lost_ && error != ENETUNREACH) refuse(address, std::strerror(error));
  }

  void send(std::span<const std::uint8_t> messages) override {
    if (!learns_) return send_to(named_, messages);
    for (const Peers::Peer& peer : peers_.all()) send_to(peer.address, messages);
  }

  std::size_t receive(std::span<std::uint8_t> out) override {
    socklen_t length = sizeof from_;
    const ssize_t size = ::recvfrom(socket_.get(), out.data(), out.size(), 0,
                                    reinterpret_cast<sockaddr*>(&from_), &length);
    return size > 0 ? static_cast<std::size_t>(size) : 0;
  }

  void accepted(bool is_signed, std::int64_t now_us) override {
    if (learns_) peers_.accepted(from_, is_signed, now_us);
  }

  bool datagrams() const override { return true; }
  int descriptor() const override { return socket_.get(); }

  /// Reopens after the network came late, or this machine's address changed.
  void maintain(std::int64_t now_us) override {
    peers_.forget_silent(now_us);
    if (lost_ && !learns_) lost_ = open() != 0;
  }

 private:
  /// 0 or errno.
  int open() {
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
    socket_ = std::move(socket);
    return 0;
  }

  void send_to(const sockaddr_in& peer, std::span<const std::uint8_t> messages) {
    const ssize_t sent = ::sendto(socket_.get(), messages.data(), messages.size(), MSG_NOSIGNAL,
                                  generic(peer), sizeof peer);
    // ECONNREFUSED: nobody listens there yet; MAVLink messages repeat.
    if (sent >= 0 || errno == ECONNREFUSED) return;
    ++dropped_;
    lost_ = errno != EAGAIN && errno != ENOBUFS;
  }

  bool learns_, broadcasts_;
  bool lost_ = false;  // nothing can be sent until open() succeeds
  sockaddr_in named_{};
  FileDescriptor socket_;
  Peers peers_;
  sockaddr_in from_{};  // of the last datagram
};

struct Speed {
  unsigned baud;
  speed_t code;
};
constexpr std::array kSpeeds{Speed{9600, B9600},     Speed{19200, B19200},   Speed{38400, B38400},
                             Speed{57600, B57600},   Speed{115200, B115200}, Speed{230400, B230400},
                             Speed{460800, B460800}, Speed{921600, B921600}};

/// A byte stream. Bytes that the port cannot take at once wait; while they do, a tick's output is
/// dropped whole, so no message is cut.
class SerialEndpoint final : public MavlinkEndpoint {
 public:
  SerialEndpoint(std::string_view address, const Address& parts) : device_(parts.place) {
    const unsigned baud = number_of(address, parts.number, 921600);
    const auto speed = std::find_if(kSpeeds.begin(), kSpeeds.end(),
                                    [&](const Speed& s) { return s.baud == baud; });
    if (speed == kSpeeds.end()) refuse(address, parts.number + " Bd is no usual rate");
    speed_ = speed->code;
    if (!open() && errno != ENOENT && errno != ENXIO && errno != ENODEV) {
      refuse(address, std::strerror(errno));
    }
  }

  void send(std::span<const std::uint8_t> messages) override {
    flush();
    if (!port_ || !waiting_.empty()) {
      ++dropped_;
      return;
    }
    waiting_.assign(messages.begin(), messages.end());
    flush();
  }

  std::size_t receive(std::span<std::uint8_t> out) override {
    if (!port_) return 0;
    const ssize_t size = ::read(port_.get(), out.data(), out.size());
    if (size > 0) return static_cast<std::size_t>(size);
    if (size == 0 || (errno != EAGAIN && errno != EINTR)) port_ = FileDescriptor();
    return 0;
  }

  bool datagrams() const override { return false; }
  int descriptor() const override { return port_.get(); }

  void maintain(std::int64_t /*now_us*/) override {
    if (!port_) open();
    flush();
  }

 private:
  bool open() {
    FileDescriptor port(::open(device_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
    termios settings{};
    if (!port || ::tcgetattr(port.get(), &settings) != 0) return false;
    ::cfmakeraw(&settings);
    settings.c_cflag |= CLOCAL | CREAD;
    settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
    ::cfsetispeed(&settings, speed_);
    ::cfsetospeed(&settings, speed_);
    if (::tcsetattr(port.get(), TCSANOW, &settings) != 0) return false;
    waiting_.clear();
    port_ = std::move(port);
    return true;
  }

  void flush() {
    if (!port_ || waiting_.empty()) return;
    const ssize_t size = ::write(port_.get(), waiting_.data(), waiting_.size());
    if (size > 0) {
      waiting_.erase(waiting_.begin(), waiting_.begin() + size);
    } else if (size < 0 && errno != EAGAIN && errno != EINTR) {
      port_ = FileDescriptor();
    }
  }

  std::string device_;
  speed_t speed_ = B57600;
  FileDescriptor port_;
  std::vector<std::uint8_t> waiting_;
};

}  // namespace

std::unique_ptr<MavlinkEndpoint> open_mavlink_endpoint(std::string_view address) {
  const Address parts = split(address);
  if (parts.scheme == "serial") return std::make_unique<SerialEndpoint>(address, parts);
  if (parts.scheme == "udpin" || parts.scheme == "udpout" || parts.scheme == "udpbcast") {
    return std::make_unique<UdpEndpoint>(address, parts);
  }
  refuse(address, "unknown kind \"" + parts.scheme + "\": udpin, udpout, udpbcast or serial");
}

}  // namespace flotilla::target
