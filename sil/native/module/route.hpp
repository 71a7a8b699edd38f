// SPDX-License-Identifier: MIT
#pragma once

#include <nanobind/nanobind.h>

/// Binds `sail_route`, the motion of a leader along waypoints.
void bind_route(nanobind::module_& m);
