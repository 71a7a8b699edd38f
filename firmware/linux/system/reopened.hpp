// SPDX-License-Identifier: MIT
// A device of the control loop that another thread opens and closes, because both may block.
#pragma once

#include <atomic>

namespace flotilla::target {

/// A default-constructed `Device` is closed. Functions are for the loop unless marked otherwise.
template <class Device>
class Reopened {
 public:
  explicit operator bool() const { return in_use_; }
  Device* operator->() { return &device_; }
  const Device* operator->() const { return &device_; }

  /// Takes over a device that the other thread has opened; false if there is none.
  bool take() {
    if (in_use_ || !ready_.load(std::memory_order_acquire)) return false;
    return in_use_ = true;
  }

  /// Returns the device, for the other thread to close and reopen.
  void give_up() {
    if (!in_use_) return;
    in_use_ = false;
    ready_.store(false, std::memory_order_release);
  }

  /// For the other thread: opens a closed device by `open(device)`, which returns 0 or errno.
  template <class Open>
  void reopen(Open open) {
    if (ready_.load(std::memory_order_acquire)) return;
    device_ = Device();
    const int error = open(device_);
    error_.store(error, std::memory_order_relaxed);
    ready_.store(error == 0, std::memory_order_release);
  }

  /// errno of the last attempt.
  int error() const { return error_.load(std::memory_order_relaxed); }

 private:
  Device device_;
  bool in_use_ = false;
  std::atomic<bool> ready_{false};  // true: the loop owns it; false: the other thread does
  std::atomic<int> error_{0};
};

}  // namespace flotilla::target
