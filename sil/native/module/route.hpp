// SPDX-License-Identifier: MIT
#pragma once

#include <nanobind/nanobind.h>

/// Binds `sail_route`, the reference that a leader makes of waypoints.
void bind_route(nanobind::module_& m);
