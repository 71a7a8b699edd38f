// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string_view>

namespace flotilla::app {

constexpr std::uint8_t kVersionMajor = 0;
constexpr std::uint8_t kVersionMinor = 1;

/// The first eight characters of the source's git commit, "unknown" where it was built without git.
std::string_view source_revision();

/// "FLOT" before a boat's system id: the id by which ground stations know it again.
constexpr std::uint64_t kUidFamily = 0x464C'4F54'0000'0000;

}  // namespace flotilla::app
