# SPDX-License-Identifier: MIT
"""Physics of the boats: knows no protocol, no wall time, no unseeded random number.

Vessels are rows of float64 arrays, in SI units and radians, north-east-down; kernels are
compiled by numba without fast-math, so that a run repeats bit for bit.
"""
