// SPDX-License-Identifier: MIT
// Saves the timestamp of MAVLink 2 signing across restarts: the timestamp must not go back even if
// the clock does, or old messages would pass for new. After a crash, messages stamped since the
// last save can be replayed. The timestamp is saved every 5 s: more often would wear an SD card,
// because each save syncs file and directory.
//
//   flotilla-signing-time 1 37500000000000
//   crc32 = 89ABCDEF
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "linux/system/first_error.hpp"
#include "linux/system/repeating_thread.hpp"

namespace flotilla::target {

struct StoredSigningTime {
  std::uint64_t timestamp = 0;  ///< as link::Signing::timestamp(); 0: none
  std::string note;             ///< for the operator, or empty
};

/// Never throws for the content of the disk.
StoredSigningTime load_signing_time(const std::filesystem::path& path);

/// Writes at once, at an interval and at the end, in its own thread: an armed boat must not wait
/// for the disk. put() and error() are for the control loop; they never block, throw or allocate.
class SigningTime {
 public:
  /// Throws std::system_error if the thread cannot be started.
  SigningTime(std::filesystem::path path, std::uint64_t timestamp,
              std::chrono::milliseconds every = std::chrono::seconds(5));

  void put(std::uint64_t timestamp) { timestamp_.store(timestamp, std::memory_order_relaxed); }

  /// Whether the system's clock can be trusted, as of the last write.
  bool clock_is_set() const { return clock_is_set_.load(std::memory_order_relaxed); }

  /// The first error with the file, once. Writing is retried.
  std::optional<std::string> error() { return error_.take(); }

 private:
  void write();

  std::filesystem::path path_;
  std::atomic<std::uint64_t> timestamp_;
  std::atomic<bool> clock_is_set_;
  FirstError error_;
  RepeatingThread writer_;
};

}  // namespace flotilla::target
