// SPDX-License-Identifier: MIT
#pragma once

#include <nanobind/nanobind.h>

/// Binds the supervisor's table, conditions and decisions, for the documentation.
void bind_supervisor(nanobind::module_& m);
