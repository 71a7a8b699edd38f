// SPDX-License-Identifier: MIT
// Writes lines to stderr from a separate thread, because a disk or a terminal may be slow.
#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>

#include "linux/logs/log_ring.hpp"
#include "linux/system/repeating_thread.hpp"

namespace flotilla::target {

class LineWriter {
 public:
  LineWriter();

  /// For one thread; never blocks. Lines without room are dropped, and counted in a later line. The
  /// destructor writes only what the reader accepts without blocking.
  void put(std::string_view line);

 private:
  void drain();
  void write();

  LogRing ring_;
  std::atomic<std::uint32_t> dropped_{0};
  std::string waiting_;  // for the thread only
  RepeatingThread thread_;
};

}  // namespace flotilla::target
