// SPDX-License-Identifier: MIT
// The boat's parameters on the disk: loaded at the start, saved when the operator changes them.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/operator/vehicle.hpp"
#include "linux/files/parameter_file.hpp"
#include "linux/files/parameter_saver.hpp"

namespace flotilla::target {

/// For the control loop: only the constructor and finish() wait for the disk.
class SavedParameters {
 public:
  explicit SavedParameters(const std::filesystem::path& file);

  /// The values that the disk should hold.
  const app::Parameters& values() const { return loaded_.values; }
  /// Notes for the operator on how they were loaded.
  const std::vector<std::string>& notes() const { return loaded_.notes; }
  /// Defaults, or old values, are in force until an operator saves.
  bool must_be_confirmed() const { return loaded_.must_be_confirmed; }
  /// The last save failed; it is retried.
  bool save_failed() const { return save_failed_; }

  /// Sets the boat's parameters at the start: values(), with the configuration's overrides.
  void begin(const app::Parameters& in_force) { noted_ = in_force; }

  /// Saves the operator's changes since the last call. Returns a sentence about the outcome of a
  /// save, if there is one.
  std::optional<std::string> maintain(app::SaveRequest request, const app::Parameters& in_force,
                                      std::int64_t now_us);

  /// Saves the remaining changes and waits for the disk. Returns sentences about the outcome.
  std::vector<std::string> finish(app::SaveRequest request, const app::Parameters& in_force);

 private:
  void note_changes(app::SaveRequest request, const app::Parameters& in_force);
  void save_changes(std::int64_t now_us);
  bool may_save() const;
  std::optional<std::string> outcome();
  std::optional<std::string> saved(std::string_view why, const std::optional<std::string>& fault);

  std::filesystem::path file_;
  LoadedParameters loaded_;
  app::Parameters noted_;  // the boat's, at the last note_changes()
  app::SaveRequest to_save_ = app::SaveRequest::kNone;
  std::int64_t saved_us_ = 0;  // start of the last save
  bool save_failed_ = false;   // the last save failed, and that was reported
  ParameterSaver saver_;
};

}  // namespace flotilla::target
