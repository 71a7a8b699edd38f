// SPDX-License-Identifier: MIT
// Repeats work that may wait for a disk or a device, in a thread beside the control loop.
#pragma once

#include <pthread.h>

#include <chrono>
#include <functional>

#include "linux/system/file_descriptor.hpp"

namespace flotilla::target {

class RepeatingThread {
 public:
  /// Calls `work`, which must not throw, at once, at an interval, and a last time at the end. Throws
  /// std::system_error that names `whose`.
  RepeatingThread(std::chrono::milliseconds every, std::function<void()> work, const char* whose);
  ~RepeatingThread();
  RepeatingThread(const RepeatingThread&) = delete;
  RepeatingThread& operator=(const RepeatingThread&) = delete;

 private:
  static void* run(void* self);

  std::chrono::milliseconds every_;
  std::function<void()> work_;
  FileDescriptor stop_;
  pthread_t thread_;
};

}  // namespace flotilla::target
