# SPDX-License-Identifier: MIT
"""Physics of the boats: knows no protocol, no wall time, no unseeded random number.

Vessels are rows of float64 arrays, in SI units and radians, north-east-down. Loops over them are
in C++ (`sil/native/plant`), which shares nothing with the firmware.
"""
