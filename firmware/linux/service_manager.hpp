// SPDX-License-Identifier: MIT
// Notifies systemd, for a service of Type=notify with a watchdog.
// Source: sd_notify(3), "Stand-alone implementations".
#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include "linux/system/file_descriptor.hpp"

namespace flotilla::target {

/// Does nothing without a service manager. Never blocks.
class ServiceManager {
 public:
  ServiceManager() {
    const char* path = std::getenv("NOTIFY_SOCKET");
    const char* watchdog = std::getenv("WATCHDOG_USEC");
    if (watchdog != nullptr) interval_us_ = std::atoll(watchdog) / 3;
    if (path == nullptr || std::strlen(path) >= sizeof address_.sun_path) return;
    address_.sun_family = AF_UNIX;
    std::memcpy(address_.sun_path, path, std::strlen(path));
    length_ = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + std::strlen(path));
    if (path[0] == '@') address_.sun_path[0] = '\0';
    socket_ = FileDescriptor(::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  }

  void notify(std::string_view what) const {
    if (!socket_) return;
    ::sendto(socket_.get(), what.data(), what.size(), MSG_NOSIGNAL,
             reinterpret_cast<const sockaddr*>(&address_), length_);
  }

  /// Call only from the control tick, so that the watchdog detects a hung loop.
  void alive(std::int64_t now_us) {
    if (interval_us_ <= 0 || now_us - last_us_ < interval_us_) return;
    last_us_ = now_us;
    notify("WATCHDOG=1");
  }

 private:
  FileDescriptor socket_;
  sockaddr_un address_{};
  socklen_t length_ = 0;
  std::int64_t interval_us_ = 0;
  std::int64_t last_us_ = 0;
};

}  // namespace flotilla::target
