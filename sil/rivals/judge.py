# SPDX-License-Identifier: MIT
"""Judges how well a boat sailed the rounded plan, and how well its followers kept their places."""

from dataclasses import dataclass

import numpy as np

from sil.plant.hull import Array
from sil.rivals.routes import arrival
from sil.scenario.scenario import Scenario

_THERE_M = 0.5
_LEARNS_S = (
    20.0  # this first part is not judged: followers begin in their places and learn the current
)
_TRACK_EVERY = 5


@dataclass(frozen=True)
class Figures:
    """The figures of one route.

    `mean_m`, `worst_m`: distance of boat 1 from the rounded plan. `speed`: the planned time over
    the time until the boat came within 0.5 m of the end, 0 if it never did. `followers_m`: the
    worst follower's RMS distance from its place relative to boat 1's true position, NaN without
    followers.
    """

    mean_m: float
    worst_m: float
    speed: float
    followers_m: float


def figures(one: Scenario, eta: Array, keep_s: float, *, fleet: bool) -> Figures:
    """Judge true poses (T, N, 3), every `keep_s`; `fleet`: boats 2 … N follow boat 1."""
    plan = one.route()
    plan = plan[: arrival(plan, len(one.leader.waypoints)) + 1]
    end, track = plan[-1, :2], plan[::_TRACK_EVERY, :2]
    near = np.hypot(*(eta[:, 0, :2] - end).T) < _THERE_M
    # Some routes pass near their end earlier: only the second half of the time counts.
    half = round(0.5 * len(plan) * one.step_s / keep_s)
    near[:half] = False
    there = int(near.argmax()) if near.any() else len(eta)
    planned_s = one.step_s * int((np.hypot(*(plan[:, :2] - end).T) < _THERE_M).argmax())
    off = np.array([np.hypot(*(track - at).T).min() for at in eta[:there, 0, :2]])
    followers_m = float("nan")
    if fleet:
        judged = slice(round(_LEARNS_S / keep_s), there)
        slots = np.array([boat.offset_m for boat in one.boat[1:]])
        apart = eta[judged, 1:, :2] - eta[judged, :1, :2] - slots
        followers_m = float(np.sqrt(np.square(apart).sum(axis=2).mean(axis=0)).max())
    speed = planned_s / (there * keep_s) if near.any() else 0.0
    return Figures(float(off.mean()), float(off.max()), speed, followers_m)
