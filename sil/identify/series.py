# SPDX-License-Identifier: MIT
"""Series of values from the messages of a log, and the log made from them."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from math import isfinite

import numpy as np

from sil.identify.voyage_log import BadLogError, Channel, VoyageLog, sampled


@dataclass
class Series:
    """Rows (time s, values …) in order of arrival; velocity north and east, or ahead and aside."""

    name: str
    position: list[tuple[float, float, float]] = field(default_factory=list)
    heading: list[tuple[float, float]] = field(default_factory=list)
    velocity: list[tuple[float, float, float]] = field(default_factory=list)
    rate: list[tuple[float, float]] = field(default_factory=list)
    commands: list[tuple[float, float, float]] = field(default_factory=list)
    aboard: bool = False  # the velocity is ahead and to starboard

    def log(self) -> VoyageLog:
        """The log. Raises `BadLogError` if a series is missing."""
        wanted = {
            "position": _in_order(self.position),
            "heading": _in_order(self.heading),
            "velocity": _in_order(self.velocity),
            "yaw rate": _in_order(self.rate),
            "propeller commands": _in_order(self.commands),
        }
        missing = [name for name, rows in wanted.items() if len(rows) < 2]
        if missing:
            raise BadLogError(
                f"{self.name}: contains no {', no '.join(missing)}. Needed are ODOMETRY, or "
                "ATTITUDE and LOCAL_POSITION_NED, and SERVO_OUTPUT_RAW or flotillad's CAN log "
                "beside it."
            )
        position, heading, velocity, rate, commands = (
            np.array(rows, dtype=float) for rows in wanted.values()
        )
        heading[:, 1] = np.unwrap(heading[:, 1])
        if not self.aboard:
            psi = np.interp(velocity[:, 0], heading[:, 0], heading[:, 1])
            north, east = velocity[:, 1].copy(), velocity[:, 2].copy()
            velocity[:, 1] = np.cos(psi) * north + np.sin(psi) * east
            velocity[:, 2] = np.cos(psi) * east - np.sin(psi) * north
        motion = [Channel(x[:, 0], x[:, 1:]) for x in (position, heading, velocity, rate)]
        return sampled(self.name, motion, Channel(commands[:, 0], commands[:, 1:]))


def _in_order(rows: Sequence[tuple[float, ...]]) -> list[tuple[float, ...]]:
    """Rows of finite values by time, the first of each instant."""
    finite = {row[0]: row for row in reversed(rows) if all(map(isfinite, row))}
    return sorted(finite.values())
