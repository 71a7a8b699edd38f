# SPDX-License-Identifier: MIT
"""A boat's state in its HEARTBEAT; firmware/docs/SUPERVISOR.md lists the fields by state."""

MANUAL, HOLD, LOITER, FORMATION, AUTO, RTL, GUIDED = 0, 4, 5, 6, 10, 11, 15  # custom_mode

_ARMED, _TEST = 128, 2  # base_mode
_CRITICAL, _EMERGENCY = 5, 6  # system_status
_MODES = {
    MANUAL: "MANUAL",
    HOLD: "HOLD",
    LOITER: "LOITER",
    FORMATION: "FORMATION",
    AUTO: "AUTO",
    RTL: "RTL",
    GUIDED: "GUIDED",
}


def state_of(custom_mode: int, base_mode: int, system_status: int) -> str | None:
    """The state, one of `flotilla.STATES`, in a boat's HEARTBEAT; None if it contains none."""
    if system_status == _EMERGENCY:
        return "FAULT"
    if not base_mode & _ARMED:
        return "DISARMED"
    if base_mode & _TEST:
        return "TEST"
    mode = _MODES.get(custom_mode)
    return "COAST" if mode == "FORMATION" and system_status == _CRITICAL else mode
