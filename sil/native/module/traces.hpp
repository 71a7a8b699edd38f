// SPDX-License-Identifier: MIT
#pragma once

#include <nanobind/nanobind.h>

/// Loops over the samples of whole runs: notes of a tick, formation errors, distances, frames.
void bind_traces(nanobind::module_& m);
