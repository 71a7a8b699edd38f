// SPDX-License-Identifier: MIT
#pragma once

#include <nanobind/nanobind.h>

/// flotilla.Fleet: everything that is on a wire in many lockstep runs; flotilla.STATES.
void bind_fleet(nanobind::module_& m);
