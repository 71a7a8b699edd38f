// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>

namespace flotilla::app {

constexpr std::uint8_t kVersionMajor = 0;
constexpr std::uint8_t kVersionMinor = 1;

}  // namespace flotilla::app
