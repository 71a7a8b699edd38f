# SPDX-License-Identifier: MIT
"""Constants of all simulated vessels: ids on MAVLink and CAN, the world's origin and frame."""

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.wire.geodesy import LocalFrame

VIRTUAL_LEADER_SYSTEM = 100
# Longjumeau's latitude and longitude in degE7, altitude in mm; any other place would do.
ORIGIN = (487_000_000, 22_950_000, 40_000)
HEIGHT_M = 0.001 * ORIGIN[2]
WORLD = LocalFrame(*ORIGIN[:2], HEIGHT_M)
BATTERY_V = 24.0
ESC_NODES = (21, 22)
NAVIGATION_COMPONENT: int = mavlink.MAV_COMP_ID_GPS
