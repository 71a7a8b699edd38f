// SPDX-License-Identifier: MIT
// Saves parameters while the boat sails: the disk keeps a thread waiting, never the control loop.
#pragma once

#include <pthread.h>

#include <atomic>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "app/boat.hpp"
#include "app/parameters.hpp"

namespace flotilla::target {

/// Of one thread; only finish() blocks.
class ParameterSaver {
 public:
  struct Saved {
    app::SaveRequest why;
    std::optional<std::string> fault;  ///< what went wrong, as a sentence
  };

  /// `unknown`: see save_parameters(). Throws std::system_error where no thread can be made.
  ParameterSaver(std::filesystem::path file, std::vector<std::string> unknown);
  ~ParameterSaver() { finish(); }
  ParameterSaver(const ParameterSaver&) = delete;
  ParameterSaver& operator=(const ParameterSaver&) = delete;

  /// Begins to save. False until the outcome of the save before has been taken: come again.
  bool save(const app::Parameters& values, app::SaveRequest why);

  /// What came of the last save, once.
  std::optional<Saved> outcome();

  /// Waits for a save under way and ends the thread; there is no save() after it.
  void finish();

 private:
  enum State : int { kIdle, kWork, kDone, kEnd };

  static void* run(void* self);
  void write();

  std::filesystem::path file_;
  std::vector<std::string> unknown_;

  // The thread's while it has work, else the loop's.
  app::Parameters values_;
  Saved saved_{};

  std::atomic<int> state_{kIdle};
  bool running_ = true;
  pthread_t thread_;
};

}  // namespace flotilla::target
