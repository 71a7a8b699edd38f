// SPDX-License-Identifier: MIT
// Reads the logs in a directory for the control loop, which asks and never waits.
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

/// Call all but the constructor from one thread. One question at a time.
class LogShelf {
 public:
  struct Log {
    std::filesystem::path file;
    std::uint32_t size = 0, time_s = 0;  ///< Unix time of the last change
  };
  /// The list of the logs, or bytes of the log with that number in the last list.
  struct Question {
    bool list = false;
    std::size_t log = 0;
    std::uint32_t offset = 0;
    std::size_t bytes = 0;  ///< at most
  };
  /// Valid until the next question.
  struct Answer {
    Question question;
    std::span<const Log> logs;
    std::span<const std::uint8_t> bytes;  ///< fewer at the end of the log, none if it is gone
  };

  /// Throws std::system_error if the thread cannot be started.
  explicit LogShelf(std::filesystem::path directory);

  /// Ignored while a question is open.
  void ask(const Question& question);
  /// The answer to the last question, once.
  std::optional<Answer> take();

 private:
  enum class State : std::uint8_t { kIdle, kAsked, kAnswered };

  void work();
  void list();
  void read();

  std::filesystem::path directory_;
  std::atomic<State> state_{State::kIdle};  // the rest belongs to the thread while kAsked
  Question question_;
  std::vector<Log> logs_;
  std::vector<std::uint8_t> bytes_;
  RepeatingThread reader_;  // last: it uses the others
};

}  // namespace flotilla::target
