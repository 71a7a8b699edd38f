// SPDX-License-Identifier: MIT
// The place of a vessel that the boat only keeps clear of, from any message that tells it.
#pragma once

#include <optional>

#include "app/convert/convert.hpp"
#include "link/mavlink/messages.hpp"

namespace flotilla::app::convert {

/// Position and velocity, in the sender's local frame or global; the heading does not matter. A
/// vessel that does not report its motion counts as at rest.
template <class S>
std::optional<Sample<S>> place_of(const link::Message& message);

}  // namespace flotilla::app::convert
