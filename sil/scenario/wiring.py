# SPDX-License-Identifier: MIT
"""Constants of all simulated vessels: ids on MAVLink and CAN, the world's origin."""

from pymavlink.dialects.v20 import ardupilotmega as mavlink

VIRTUAL_LEADER_SYSTEM = 100
# Longjumeau's latitude and longitude in degE7, altitude in mm; any other place would do.
ORIGIN = (487_000_000, 22_950_000, 40_000)
BATTERY_V = 24.0
ESC_NODES = (21, 22)
NAVIGATION_COMPONENT: int = mavlink.MAV_COMP_ID_GPS
