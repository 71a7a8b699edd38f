// SPDX-License-Identifier: MIT
// The timestamp of MAVLink 2 signing, kept over a restart: it must not go back even where the clock
// does, or old messages would pass for new.
//
//   flotilla-signing-time 1 37500000000000
//   crc32 = 89ABCDEF
#pragma once

#include <pthread.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "linux/file_descriptor.hpp"
#include "linux/first_complaint.hpp"

namespace flotilla::target {

struct StoredSigningTime {
  std::uint64_t timestamp = 0;  ///< as link::Signing::timestamp(); 0: there is none
  std::string note;             ///< what to tell the operator, or nothing
};

/// Never throws for what is on the disk.
StoredSigningTime load_signing_time(const std::filesystem::path& path);

/// Writes at once, then in that interval, and at its end, in a thread of its own: an armed boat waits for no
/// disk. put() and complaint() belong to the control loop and never block, throw or allocate.
class SigningTime {
 public:
  /// Throws std::system_error where no thread can be made.
  SigningTime(std::filesystem::path path, std::uint64_t timestamp,
              std::chrono::milliseconds every = std::chrono::seconds(30));
  ~SigningTime();
  SigningTime(const SigningTime&) = delete;
  SigningTime& operator=(const SigningTime&) = delete;

  void put(std::uint64_t timestamp) { timestamp_.store(timestamp, std::memory_order_relaxed); }

  /// The first thing that went wrong with the file, once. Writing is tried again.
  std::optional<std::string> complaint() { return complaint_.take(); }

 private:
  static void* run(void* self);
  void write_until_stopped();
  void write();

  std::filesystem::path path_;
  std::atomic<std::uint64_t> timestamp_;
  std::chrono::milliseconds every_;
  FirstComplaint complaint_;

  FileDescriptor stop_;
  pthread_t writer_{};
};

}  // namespace flotilla::target
