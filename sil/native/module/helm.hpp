// SPDX-License-Identifier: MIT
#pragma once

#include <nanobind/nanobind.h>

/// Binds flotilla.Helm: the boat's observer and law alone.
void bind_helm(nanobind::module_& m);
