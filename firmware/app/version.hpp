// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string_view>

namespace flotilla::app {

constexpr std::uint8_t kVersionMajor = 0;
constexpr std::uint8_t kVersionMinor = 1;

/// First eight characters of the source's git commit; "unknown" if built without git.
std::string_view source_revision();

/// Upper half of a boat's uid ("FLOT"); the system id is added. Ground stations identify the boat
/// by the uid.
constexpr std::uint64_t kUidFamily = 0x464C'4F54'0000'0000;

}  // namespace flotilla::app
