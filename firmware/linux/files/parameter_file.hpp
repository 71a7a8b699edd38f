// SPDX-License-Identifier: MIT
// The boat's parameters on disk: readable, with a checksum, and with the previous version kept.
//
//   flotilla-parameters 1
//   MAV_SYSID = 1
//   LAW_KX = 0.2
//   …
//   crc32 = 89ABCDEF
//
// The checksum (IEEE 802.3) covers every byte before its line, and its line is compared byte for
// byte: truncation and any single flipped bit are detected. `path.previous` and `path` are each
// replaced by a rename, one after the other, and only a readable file becomes the previous one: at
// every moment at least one of the two is intact.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "app/parameters.hpp"

namespace flotilla::target {

enum class ParameterSource : std::uint8_t {
  kFile,
  kPrevious,    ///< the file cannot be used or is missing, the previous version is intact
  kDefaults,    ///< both are damaged, or one is damaged and the other absent
  kFirstStart,  ///< neither exists: a boat that was never set up, or lost its files; defaults
};

struct LoadedParameters {
  app::Parameters values;  ///< each valid, without contradictions
  ParameterSource source = ParameterSource::kFirstStart;
  /// The values are defaults or older ones, and unconfirmed: arming is blocked until an operator
  /// saves. Never save without being asked before that, or the next start would not ask again.
  bool must_be_confirmed = false;
  std::vector<std::string> unknown;  ///< unknown lines, kept for the next save
  std::vector<std::string> notes;    ///< sentences for the operator
};

/// Never throws for the content of the disk.
LoadedParameters load_parameters(const std::filesystem::path& path);

/// Blocks on the disk: see ParameterSaver. Writes nothing if the file has that content already.
/// Returns an error as a sentence.
std::optional<std::string> save_parameters(const std::filesystem::path& path,
                                           const app::Parameters& values,
                                           std::span<const std::string> unknown);

/// The content of the file that save_parameters() writes.
std::string parameter_text(const app::Parameters& values, std::span<const std::string> unknown);

}  // namespace flotilla::target
