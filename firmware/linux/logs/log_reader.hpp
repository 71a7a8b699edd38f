// SPDX-License-Identifier: MIT
// Reads the logs in a directory for the control loop, which never waits for them.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

#include "linux/system/repeating_thread.hpp"

namespace flotilla::target {

/// Call all but the constructor from one thread. Serves one request at a time.
class LogReader {
 public:
  struct Log {
    std::filesystem::path file;
    std::uint32_t size = 0, time_s = 0;  ///< Unix time of the last change
  };
  /// The list of the logs, or bytes of the log with that number in the last list.
  struct Request {
    bool list = false;
    std::size_t log = 0;
    std::uint32_t offset = 0;
    std::size_t bytes = 0;  ///< at most
  };
  /// Valid until the next request.
  struct Answer {
    Request request;
    std::span<const Log> logs;
    std::span<const std::uint8_t> bytes;  ///< fewer at the end of the log, none if it is gone
  };

  /// Throws std::system_error if the thread cannot be started.
  explicit LogReader(std::filesystem::path directory);

  /// Ignored while a request is open.
  void ask(const Request& request);
  /// The answer to the last request, once.
  std::optional<Answer> take();

 private:
  enum class State : std::uint8_t { kIdle, kAsked, kAnswered };

  void work();
  void list();
  void read();

  std::filesystem::path directory_;
  std::atomic<State> state_{State::kIdle};  // kAsked: the thread owns the members below
  Request request_;
  std::vector<Log> logs_;
  std::vector<std::uint8_t> bytes_;
  RepeatingThread reader_;  // last: it uses the others
};

}  // namespace flotilla::target
