// SPDX-License-Identifier: MIT
// Convert, of FORMATION_REFERENCE: the root's motion, slots in whole parts of a metre.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/convert/convert.hpp"
#include "core/reference.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app::convert {

/// A slot as the wire has it, 1/1024 m.
using WireOffset = std::array<std::int32_t, 2>;

WireOffset wire_offset_of(float a_m, float b_m);

/// Nothing where it is farther than any fleet reaches.
std::optional<WireOffset> sum_of(const WireOffset& a, const WireOffset& b);

template <class S>
core::Vec2<S> offset_of(const WireOffset& offset);

/// The root as it was when the reference was true.
template <class S>
struct RootState {
  Position position;
  core::ReferenceMotion<S> motion;
};

/// Nothing where no vessel can be so; altitude_mm: of the water.
template <class S>
std::optional<RootState<S>> root_state_of(const link::ReferenceMotion& message,
                                          std::int32_t altitude_mm);

/// Nothing where it is beyond what the message can say.
template <class S>
std::optional<link::ReferenceMotion> reference_motion_of(const RootState<S>& root);

/// Shares of the speed and of the yaw rate that the boat itself approaches its slot by.
template <class S>
core::ForesightLimits<S> foresight_limits(const Parameters& p);

}  // namespace flotilla::app::convert
