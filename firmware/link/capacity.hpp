// SPDX-License-Identifier: MIT
// How much a boat has room for. All of it is inside the boat: nothing grows.
#pragma once

#include <cstddef>

namespace flotilla::link {

#ifdef FLOTILLA_SMALL
/// A microcontroller: one radio, one serial line.
constexpr std::size_t kMaxLinks = 2, kSigningStreams = 16;
#else
constexpr std::size_t kMaxLinks = 4, kSigningStreams = 255;
#endif

}  // namespace flotilla::link
