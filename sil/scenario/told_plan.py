# SPDX-License-Identifier: MIT
"""Agent 0 if a boat leads: the plan, sailed by the planner alone, at the boat's plan time.

The planner determines the path of agent 0. The boat's FORMATION_REFERENCE determines its progress
along that path: the boat first turns to the first leg, and the plan waits if the boat falls behind.
Progress is found by comparing place and surge of both. Agent 0 moves smoothly, and waits while no
reference arrives.
"""

import numpy as np

from sil.plant.hull import Array
from sil.scenario.route import PLANS_LARGEST_M
from sil.scenario.sections import Leader
from sil.scenario.wiring import HEIGHT_M, WORLD
from sil.wire.formation_reference import Ear
from sil.wire.plan_upload import PlanItem, speed_item, voyage_item, waypoint_item

_SILENT_US = 1_000_000
_AROUND_S = 5.0  # search window for the plan time, to either side of agent 0
_GAIN = 5.0  # 1/s
_FASTEST = 3.0  # multiple of the planned speed while agent 0 catches up
_ALIKE_S = 1.0  # weight of surge, m/s, against place, m


def items_of(leader: Leader) -> list[PlanItem]:
    """The plan for a boat: its speed, and all waypoints except the one where it starts.

    A voyage that measures the hull replaces the last waypoint.
    """
    radius_m = 0.0 if leader.corner_radius_m is None else PLANS_LARGEST_M
    places = [WORLD.geodetic(north, east, 0.0) for north, east in leader.waypoints[1:]]
    points = [waypoint_item(place.latitude, place.longitude, radius_m) for place in places]
    if leader.voyage_room_m is not None:
        share, room_m = leader.voyage_share, leader.voyage_room_m
        points[-1] = voyage_item(places[-1].latitude, places[-1].longitude, share, room_m)
    return [speed_item(leader.speed_mps), *points]


class ToldPlan:
    """Agent 0 on its plan. `motion` (T, 10): as `flotilla.sail_route` returns it, every `h_s`."""

    def __init__(self, motion: Array, h_s: float, system: int) -> None:
        self._motion, self._h_s = motion, h_s
        self._ear = Ear(system, WORLD, HEIGHT_M)
        self._at = 0.0  # ticks since the plan began
        self._behind = 0.0  # ticks
        self._heard_us: int | None = None
        self._rests = True

    def hear(self, data: bytes, t_us: int) -> None:
        """Process whole frames that the boat sends at `t_us`."""
        for told in self._ear.hear(data):
            self._heard_us = t_us
            self._rests = told.u_mps == 0.0
            around = round(_AROUND_S / self._h_s)
            first = max(0, int(self._at) - around)
            near = self._motion[first : int(self._at) + around]
            off = np.hypot(near[:, 0] - told.north_m, near[:, 1] - told.east_m)
            unlike = off**2 + (_ALIKE_S * (near[:, 3] - told.u_mps)) ** 2
            since = 0.0 if self._rests else 1e-6 * told.age_us / self._h_s
            self._behind = first + int(unlike.argmin()) + since - self._at

    def forward(self, t_us: int) -> tuple[Array, Array]:
        """The pose (3) and velocity (3) one tick after `t_us`."""
        silent = self._heard_us is None or t_us - self._heard_us > _SILENT_US
        step = 0.0
        if not silent:
            back = min(1.0, _GAIN * self._h_s) * self._behind
            step = min(max((0.0 if self._rests else 1.0) + back, 0.0), _FASTEST)
            self._behind += (0.0 if self._rests else 1.0) - step
        last = len(self._motion) - 1
        self._at = min(self._at + step, float(last))
        k = min(int(self._at), last - 1)
        share = self._at - k
        # plain floats: numpy takes longer for a few numbers
        a, b = self._motion[k : k + 2, :6].tolist()
        now = [before + share * (after - before) for before, after in zip(a, b, strict=True)]
        psi = a[2] + share * self._h_s * a[5]
        return np.array([now[0], now[1], psi]), np.array([step * each for each in now[3:]])
