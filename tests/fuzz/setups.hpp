// SPDX-License-Identifier: MIT
// Boats of many kinds from the first bytes of an input.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "fuzz/stream.hpp"
#include "fuzz/watched_boat.hpp"

namespace flotilla::fuzz {

/// Durations of a tick, µs: a control period first; then zero, late ticks, a long sleep.
inline constexpr std::array<std::int64_t, 8> kSteps_us{10'000,  1'000,   50'000,    0,
                                                       200'000, 490'000, 1'100'000, 7'000'000};

inline Setup setup_of(std::uint8_t kind) {
  constexpr std::array kPolicies{app::SigningPolicy::kOff, app::SigningPolicy::kAccept,
                                 app::SigningPolicy::kRequired, app::SigningPolicy::kOff};
  Setup setup;
  setup.links = 1 + (kind & 3U);
  setup.policy = kPolicies[kind >> 2U & 3U];
  if ((kind & 16U) != 0) {
    setup.parameters.MAV_IDENTITY = 1;
    setup.parameters.MAV_COMPID = 191;
  }
  if (setup.links == 4) setup.parameters.MAV_AUTOPILOT = 1;
  setup.parameters.NAV_LAG_S = setup.parameters.FORM_LAG_S = 0;  // few answer TIMESYNC in time
  if ((kind & 32U) != 0) setup.parameters.FS_SEP_M = 3;          // it looks for other vessels
  return setup;
}

/// Plays the rest of the input to a boat that its first byte describes. Bits 6, 7: the law's scalar.
template <template <class> class Play>
int play(const std::uint8_t* data, std::size_t size) {
  Stream in(std::span(data, size));
  const std::uint8_t kind = in.byte();
  switch (kind >> 6U) {
    case 1:
      Play<core::Q16>(setup_of(kind)).run(in);
      break;
    case 2:
    case 3:
      Play<double>(setup_of(kind)).run(in);
      break;
    default:
      Play<float>(setup_of(kind)).run(in);
  }
  return 0;
}

}  // namespace flotilla::fuzz
