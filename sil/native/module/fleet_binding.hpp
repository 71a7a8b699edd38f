// SPDX-License-Identifier: MIT
#pragma once

#include <nanobind/nanobind.h>

/// Binds flotilla.Fleet, the boats and links of many lockstep runs, and flotilla.STATES.
void bind_fleet(nanobind::module_& m);
