// SPDX-License-Identifier: MIT
// numpy arrays for the kernels: any stride, no conversion, so never a copy.
#pragma once

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>

namespace flotilla::plant {

/// An array of N dimensions that is written, and one that is only read.
template <std::size_t N, class T = double>
using Array = nanobind::ndarray<T, nanobind::ndim<N>, nanobind::device::cpu>;
template <std::size_t N, class T = double>
using Input = nanobind::ndarray<const T, nanobind::ndim<N>, nanobind::device::cpu>;

/// ValueError, with the argument's `name`, unless `shape` has these lengths.
template <class A, class... Lengths>
void expect(const A& array, const char* name, Lengths... lengths) {
  std::size_t axis = 0;
  if (!((array.shape(axis++) == static_cast<std::size_t>(lengths)) && ...)) {
    throw nanobind::value_error(name);
  }
}

}  // namespace flotilla::plant
