# SPDX-License-Identifier: MIT
"""A level vessel's heading (rad, clockwise from north) and its axes: ahead, to starboard."""

from math import atan2, cos, sin


def yaw(w: float, x: float, y: float, z: float) -> float:
    """The heading of an attitude: a quaternion from body to north-east-down."""
    return atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))


def aboard(psi: float, north: float, east: float) -> tuple[float, float]:
    """A vector in the axes of a vessel with heading `psi`."""
    return cos(psi) * north + sin(psi) * east, cos(psi) * east - sin(psi) * north
