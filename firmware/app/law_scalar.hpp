// SPDX-License-Identifier: MIT
// The law's scalar on a boat, as the build has it: cmake -DCTL_SCALAR=float, double or q16.
#pragma once

#include "core/scalar/fixed.hpp"

namespace flotilla::target {

using Scalar = CTL_SCALAR;

}  // namespace flotilla::target
