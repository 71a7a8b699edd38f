// SPDX-License-Identifier: MIT
// Saves parameters while the boat sails: only a background thread waits for the disk.
#pragma once

#include <pthread.h>

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/boat/boat.hpp"
#include "app/parameters.hpp"

namespace flotilla::target {

/// For one thread; only finish() blocks.
class ParameterSaver {
 public:
  struct Saved {
    app::SaveRequest why;
    std::optional<std::string> fault;  ///< the error as a sentence
  };

  /// `unknown`: see save_parameters(). Throws std::system_error if the thread cannot be started.
  ParameterSaver(std::filesystem::path file, std::vector<std::string> unknown);
  ~ParameterSaver() { finish(); }
  ParameterSaver(const ParameterSaver&) = delete;
  ParameterSaver& operator=(const ParameterSaver&) = delete;

  /// Starts a save. False until the outcome of the last save has been taken: try again later.
  bool save(const app::Parameters& values, app::SaveRequest why);

  /// The outcome of the last save, once.
  std::optional<Saved> outcome();

  /// Waits for a save in progress and ends the thread; no save() may follow.
  void finish();

 private:
  enum State : int { kIdle, kWork, kDone, kEnd };

  static void* run(void* self);
  void write();

  std::filesystem::path file_;
  std::vector<std::string> unknown_;

  // Owned by the thread while it has work, else by the loop.
  app::Parameters values_;
  Saved saved_{};

  std::atomic<int> state_{kIdle};
  bool running_ = true;
  pthread_t thread_;
};

}  // namespace flotilla::target
