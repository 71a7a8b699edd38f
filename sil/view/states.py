# SPDX-License-Identifier: MIT
"""What holds a boat in its state, asked of the firmware's own table."""

from functools import lru_cache
from typing import Any

import flotilla

_CONDITIONS: list[dict[str, Any]] = flotilla.supervisor_conditions()


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
