// SPDX-License-Identifier: MIT
// Conversion of FORMATION_REFERENCE: the root's motion, and slots in 1/1024 m.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "app/convert/convert.hpp"
#include "core/future.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app::convert {

/// A slot in the wire's unit, 1/1024 m.
using WireOffset = std::array<std::int32_t, 2>;

WireOffset wire_offset_of(float a_m, float b_m);

/// Nothing beyond 100 km, farther than any fleet reaches.
std::optional<WireOffset> sum_of(const WireOffset& a, const WireOffset& b);

float length_m(const WireOffset& offset);

template <class S>
core::Vec2<S> offset_of(const WireOffset& offset);

/// The root's state at the time the reference was valid.
template <class S>
struct RootState {
  Position position;
  core::ReferenceMotion<S> motion;
};

/// Nothing if no vessel can have this state; altitude_mm: of the water.
template <class S>
std::optional<RootState<S>> root_state_of(const link::FormationReference& message,
                                          std::int32_t altitude_mm);

/// A message with this motion and zeros in the other fields; nothing if a value exceeds the
/// message's range.
template <class S>
std::optional<link::FormationReference> reference_of(const RootState<S>& root);

/// Nothing if no boat can sail like this.
template <class S>
std::optional<core::Future<S>> future_of(const link::FormationFuture& message);

/// A message with this future, as precise as the message allows, and zeros in the other fields;
/// nothing if the future exceeds the message's range.
template <class S>
std::optional<link::FormationFuture> message_of(const core::Future<S>& future);

}  // namespace flotilla::app::convert
