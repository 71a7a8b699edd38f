// SPDX-License-Identifier: MIT
// The moving bodies around the boats. Nothing of it is shared with the firmware's vessel model: a
// mistake in one must not cancel in the other.
#pragma once

#include <nanobind/nanobind.h>

namespace flotilla::plant {

void bind_hull(nanobind::module_& m);
void bind_propeller(nanobind::module_& m);
void bind_sensors(nanobind::module_& m);
void bind_voyage(nanobind::module_& m);
void bind_weather(nanobind::module_& m);

}  // namespace flotilla::plant
