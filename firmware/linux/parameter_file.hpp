// SPDX-License-Identifier: MIT
// The boat's parameters on disk: readable, checked as a whole, with the version before.
//
//   flotilla-parameters 1
//   MAV_SYSID = 1
//   LAW_KX = 0.2
//   …
//   crc32 = 89ABCDEF
//
// The checksum (IEEE 802.3) covers every byte before its own line, and its line is compared byte
// for byte: a truncated file and any single flipped bit are found. `path` and `path.previous` are
// each replaced by a rename, one after the other, and only a readable file becomes the previous
// one: at every moment at least one of the two is whole.
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
  kPrevious,    ///< the file is damaged or gone, the version before it is whole
  kDefaults,    ///< both are damaged, or one is damaged and the other absent
  kFirstStart,  ///< there is neither: defaults, as it should be
};

struct LoadedParameters {
  app::Parameters values;  ///< each valid, together free of contradiction
  ParameterSource source = ParameterSource::kFirstStart;
  /// A value was lost to its default: no arming until an operator has looked and saved. Do not
  /// save by yourself before (at exit, say), or the next start takes the defaults for granted.
  bool must_be_confirmed = false;
  std::vector<std::string> unknown;  ///< lines nobody here knows, for the next save
  std::vector<std::string> notes;    ///< what to tell the operator, sentence by sentence
};

/// Never throws for what is on the disk.
LoadedParameters load_parameters(const std::filesystem::path& path);

/// Waits for the disk: see ParameterSaver. Nothing is written where the file says the same already.
/// What went wrong, as a sentence.
std::optional<std::string> save_parameters(const std::filesystem::path& path,
                                           const app::Parameters& values,
                                           std::span<const std::string> unknown);

/// The content of the file that save_parameters() writes.
std::string parameter_text(const app::Parameters& values, std::span<const std::string> unknown);

}  // namespace flotilla::target
