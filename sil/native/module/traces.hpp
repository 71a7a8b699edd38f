// SPDX-License-Identifier: MIT
#pragma once

#include <nanobind/nanobind.h>

/// Binds loops over whole runs: recording of a tick, formation errors, distances, frames.
void bind_traces(nanobind::module_& m);
