// SPDX-License-Identifier: MIT
// Physics of the simulated vessels. It shares no code with the firmware's vessel model, so that a
// mistake in one cannot cancel in the other.
#pragma once

#include <nanobind/nanobind.h>

namespace flotilla::plant {

void bind_hull(nanobind::module_& m);
void bind_propeller(nanobind::module_& m);
void bind_sensors(nanobind::module_& m);
void bind_voyage(nanobind::module_& m);
void bind_weather(nanobind::module_& m);

}  // namespace flotilla::plant
