# SPDX-License-Identifier: MIT
"""The conditions that keep a boat from sailing, from the firmware's own table."""

from functools import lru_cache
from typing import Any

import flotilla

_CONDITIONS: list[dict[str, Any]] = flotilla.supervisor_conditions()


@lru_cache(maxsize=1024)
def held_by(conditions: int, state: str) -> tuple[str, ...]:
    """The boat's message for each unmet condition that keeps it out of FORMATION.

    `conditions`: the bits of `flotilla.supervisor_conditions()`, set if met. A boat that can sail
    its plan is armed without a leader. A disarmed boat also needs the conditions for arming. The
    most important comes first; empty for a boat that the law drives.
    """
    if state in ("FORMATION", "AUTO", "GUIDED", "LOITER", "RTL"):
        return ()
    met = _met(conditions)
    sails = state == "DISARMED" and flotilla.supervise("HOLD", "AUTO", met)["granted"]
    missing = set() if sails else set(flotilla.supervise("HOLD", "FORMATION", met)["missing"])
    if state == "DISARMED":
        missing |= set(flotilla.supervise("DISARMED", "arm", met)["missing"])
    return tuple(c["complaint"] for c in _CONDITIONS if c["name"] in missing)


def keep_from_arming(conditions: int) -> tuple[str, ...]:
    """The boat's message for each unmet condition without which it does not arm."""
    armed = flotilla.supervise("DISARMED", "arm", _met(conditions))
    missing = () if armed["granted"] else armed["missing"]
    return tuple(c["complaint"] for c in _CONDITIONS if c["name"] in missing)


def _met(conditions: int) -> list[str]:
    return [c["name"] for c in _CONDITIONS if conditions >> c["bit"] & 1]
