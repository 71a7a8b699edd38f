# SPDX-License-Identifier: MIT
"""The physics of the boats, without protocols, wall time or unseeded random numbers.

Vessels are rows of float64 arrays, in SI units and radians, north-east-down. Loops over them are in
C++ (`sil/native/plant`), which shares nothing with the firmware.
"""
