// SPDX-License-Identifier: MIT
// The scalar of the boat's control law, set by the build: cmake -DCTL_SCALAR=float, double or q16.
#pragma once

#include "core/scalar/fixed.hpp"

namespace flotilla::target {

using Scalar = CTL_SCALAR;

}  // namespace flotilla::target
