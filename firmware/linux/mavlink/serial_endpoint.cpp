// SPDX-License-Identifier: MIT
#include "linux/mavlink/serial_endpoint.hpp"

#include <fcntl.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <utility>

namespace flotilla::target {
namespace {

struct Speed {
  unsigned baud;
  speed_t code;
};
constexpr std::array kSpeeds{Speed{9600, B9600},     Speed{19200, B19200},   Speed{38400, B38400},
                             Speed{57600, B57600},   Speed{115200, B115200}, Speed{230400, B230400},
                             Speed{460800, B460800}, Speed{921600, B921600}};

}  // namespace

speed_t speed_of(const EndpointAddress& address) {
  const auto speed = std::ranges::find(kSpeeds, number_of(address, 921600), &Speed::baud);
  if (speed == kSpeeds.end()) {
    refuse(address.whole, address.number + " is not a supported baud rate");
  }
  return speed->code;
}

SerialEndpoint::SerialEndpoint(const EndpointAddress& address)
    : device_(address.place), speed_(speed_of(address)) {
  reopen();
  port_.take();
}

int SerialEndpoint::open(FileDescriptor& fresh) const {
  FileDescriptor port(::open(device_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  termios settings{};
  if (!port || ::tcgetattr(port.get(), &settings) != 0) return errno;
  ::cfmakeraw(&settings);
  settings.c_cflag |= CLOCAL | CREAD;
  settings.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | CRTSCTS);
  ::cfsetispeed(&settings, speed_);
  ::cfsetospeed(&settings, speed_);
  if (::tcsetattr(port.get(), TCSANOW, &settings) != 0) return errno;
  fresh = std::move(port);
  return 0;
}

void SerialEndpoint::reopen() {
  port_.reopen([this](FileDescriptor& fresh) { return open(fresh); });
}

void SerialEndpoint::maintain(std::int64_t /*now_us*/) {
  if (port_.take()) waiting_.clear();
  flush();
}

void SerialEndpoint::send(std::span<const std::uint8_t> messages) {
  flush();
  if (!port_ || !waiting_.empty()) return;
  waiting_.assign(messages.begin(), messages.end());
  flush();
}

std::size_t SerialEndpoint::receive(std::span<std::uint8_t> out) {
  if (!port_) return 0;
  const ssize_t size = ::read(port_->get(), out.data(), out.size());
  if (size > 0) return static_cast<std::size_t>(size);
  if (size == 0 || (errno != EAGAIN && errno != EINTR)) port_.give_up();
  return 0;
}

void SerialEndpoint::flush() {
  if (!port_ || waiting_.empty()) return;
  const ssize_t size = ::write(port_->get(), waiting_.data(), waiting_.size());
  if (size > 0) {
    waiting_.erase(waiting_.begin(), waiting_.begin() + size);
  } else if (size < 0 && errno != EAGAIN && errno != EINTR) {
    port_.give_up();
  }
}

}  // namespace flotilla::target
