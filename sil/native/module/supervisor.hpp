// SPDX-License-Identifier: MIT
#pragma once

#include <nanobind/nanobind.h>

/// The supervisor's table, its conditions, and what it decides, for the pages that show them.
void bind_supervisor(nanobind::module_& m);
