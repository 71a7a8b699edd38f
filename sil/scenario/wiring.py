# SPDX-License-Identifier: MIT
"""What is the same aboard every vessel of a simulation: ids on its wires, place on the globe."""

from pymavlink.dialects.v20 import common as mavlink  # type: ignore[import-untyped]

VIRTUAL_LEADER_SYSTEM = 100
# Longjumeau's latitude and longitude in degE7, altitude in mm: any place will do.
ORIGIN = (487_000_000, 22_950_000, 40_000)
BATTERY_V = 24.0
ESC_NODES = (21, 22)
NAVIGATION_COMPONENT: int = mavlink.MAV_COMP_ID_GPS
