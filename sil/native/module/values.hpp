// SPDX-License-Identifier: MIT
// Python's values and ours.
#pragma once

#include <nanobind/nanobind.h>

#include "app/parameters.hpp"

/// Parameters by name, the others at their defaults; ValueError names the one that cannot be.
flotilla::app::Parameters parameters_from(const nanobind::dict& values);

nanobind::dict pair(const char* a, double x, const char* b, double y);
nanobind::dict triple(const char* a, double x, const char* b, double y, const char* c, double z);
