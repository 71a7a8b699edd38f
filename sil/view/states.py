# SPDX-License-Identifier: MIT
"""A boat's state in its HEARTBEAT, and what holds it there, asked of the firmware's own table."""

from functools import lru_cache
from typing import Any

import flotilla

_ARMED, _TEST = 128, 2  # base_mode
_CRITICAL, _EMERGENCY = 5, 6  # system_status
_MODES = {0: "MANUAL", 4: "HOLD", 6: "FORMATION"}
_CONDITIONS: list[dict[str, Any]] = flotilla.supervisor_conditions()


def state_of(custom_mode: int, base_mode: int, system_status: int) -> str | None:
    """One of `flotilla.STATES` by the fields of a boat's HEARTBEAT; None where it is none."""
    if system_status == _EMERGENCY:
        return "FAULT"
    if not base_mode & _ARMED:
        return "DISARMED"
    if base_mode & _TEST:
        return "TEST"
    mode = _MODES.get(custom_mode)
    return "COAST" if mode == "FORMATION" and system_status == _CRITICAL else mode


@lru_cache(maxsize=1024)
def held_by(conditions: int, state: str) -> tuple[str, ...]:
    """What a boat says for want of each condition that keeps it from FORMATION.

    `conditions`: the bits that `flotilla.supervisor_conditions()` names are set where they are met;
    a disarmed boat needs those for arming too. The most important comes first. Nothing holds a boat
    that is in FORMATION.
    """
    if state == "FORMATION":
        return ()
    met = [c["name"] for c in _CONDITIONS if conditions >> c["bit"] & 1]
    missing = set(flotilla.supervise("HOLD", "FORMATION", met)["missing"])
    if state == "DISARMED":
        missing |= set(flotilla.supervise("DISARMED", "arm", met)["missing"])
    return tuple(c["complaint"] for c in _CONDITIONS if c["name"] in missing)
