// SPDX-License-Identifier: MIT
// Converts between Python's values and C++.
#pragma once

#include <nanobind/nanobind.h>

#include "app/parameters.hpp"

/// Parameters by name, the others at their defaults; ValueError names an invalid one.
flotilla::app::Parameters parameters_from(const nanobind::dict& values);

nanobind::dict pair(const char* a, double x, const char* b, double y);
nanobind::dict triple(const char* a, double x, const char* b, double y, const char* c, double z);
