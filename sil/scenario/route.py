# SPDX-License-Identifier: MIT
"""The reference along the leader's waypoints, computed by the firmware's planner alone.

A virtual leader has limits that any boat can follow. A boat that leads has the limits that follow
from its firmware's parameters (`firmware/app/convert/law.cpp`).
"""

from collections.abc import Mapping, Sequence

import flotilla
import numpy as np

from sil.plant.hull import Array
from sil.scenario.sections import Boat, Leader

# Limits of a reference along waypoints: boats from the smallest to two metres can follow it.
ACCELERATION_MPS2 = 0.1
YAW_RATE_RADPS = 0.35
YAW_ACCELERATION_RADPS2 = 0.15
# Default radius of a corner: the slot on the inside keeps steerage way, and the slots ahead and
# astern need not be much faster than the leader.
_SMALLEST_M, _WIDE, _LONG = 2.0, 2.5, 1.25
_ANY_DISTANCE_M = 1e6
_UNDER_WAY_MPS = 0.01
#: Greatest distance of a plan's corner from its waypoint if `corner_radius_m` is set.
PLANS_LARGEST_M = 100.0
# Radius of a boat's corners, as a multiple of its WP_WIDTH.
_PLANS_RADIUS = 1.25


def route(
    leader: Leader,
    boats: Sequence[Boat],
    step_s: float,
    ticks: int,
    parameters: Mapping[str, float] | None = None,
) -> Array:
    """Motion (ticks + 1, 10) of a leader along waypoints, as `flotilla.sail_route` returns it.

    `parameters`: firmware parameters of a boat that leads; missing ones have their defaults.
    """
    if leader.boat is not None:
        return _plan(leader, parameters or {}, step_s, ticks)
    width_m = half_width_m(boats)
    radius_m = leader.corner_radius_m
    if radius_m is None:
        radius_m = max(_SMALLEST_M, _WIDE * width_m, _LONG * half_length_m(boats))
    points = np.zeros((len(leader.waypoints), 5))
    points[:, :2] = leader.waypoints
    points[:, 2] = leader.speed_mps
    points[:, 3] = _ANY_DISTANCE_M
    limits = (ACCELERATION_MPS2, YAW_RATE_RADPS, YAW_ACCELERATION_RADPS2)
    motion: Array = flotilla.sail_route(points, *limits, radius_m, width_m, step_s, ticks + 1)
    return motion


def _plan(leader: Leader, parameters: Mapping[str, float], step_s: float, ticks: int) -> Array:
    """The same as `route`, for a boat's plan."""
    own = flotilla.derived(parameters)
    points = np.zeros((len(leader.waypoints), 5))
    points[:, :2] = leader.waypoints
    points[:, 2] = leader.speed_mps
    points[:, 3] = own["WP_RADIUS"] if leader.corner_radius_m is None else PLANS_LARGEST_M
    force = 0.5 * own["THR_FWD_MAX"]
    moment = own["THR_ARM"] * min(force, 0.5 * own["THR_REV_MAX"])
    fastest = 0.5 * own["LAW_R_MAX"] if own["LAW_R_MAX"] > 0.0 else 1.0
    damping = own["VES_D33"] + own["VES_D33U"] * own["WP_SPEED"]
    limits = (
        min(ACCELERATION_MPS2, force / own["VES_M11"]),
        min(YAW_RATE_RADPS, fastest, moment / damping),
        min(YAW_ACCELERATION_RADPS2, moment / own["VES_M33"]),
    )
    width_m = own["WP_WIDTH"]
    radius_m = _PLANS_RADIUS * width_m
    motion: Array = flotilla.sail_route(points, *limits, radius_m, width_m, step_s, ticks + 1)
    return motion


def plans_width_m(leader: Leader, boats: Sequence[Boat]) -> float:
    """WP_WIDTH of a boat that leads: for its outermost slot and for `corner_radius_m`."""
    return max(half_width_m(boats), (leader.corner_radius_m or 0.0) / _PLANS_RADIUS)


def half_width_m(boats: Sequence[Boat]) -> float:
    """Distance to port or starboard of the outermost slot that turns with the virtual leader."""
    return max(abs(starboard) for _, starboard in turning(boats).values())


def half_length_m(boats: Sequence[Boat]) -> float:
    """Distance ahead or astern of the outermost slot that turns with the virtual leader."""
    return max(abs(ahead) for ahead, _ in turning(boats).values())


def turning(boats: Sequence[Boat]) -> dict[int, tuple[float, float]]:
    """Places ahead and to starboard (m) of the agents that turn with the virtual leader, 0."""
    places = {0: (0.0, 0.0)}
    for agent, boat in enumerate(boats, start=1):
        if boat.follows in places and boat.parameters.get("FORM_FRAME", 0.0) == 1.0:
            ahead, starboard = places[boat.follows]
            places[agent] = ahead + boat.offset_m[0], starboard + boat.offset_m[1]
    return places


def fastest(motion: Array, place: tuple[float, float]) -> tuple[float, int]:
    """Greatest speed, m/s, of a place that turns with a route's motion; its waypoint, from 1."""
    ahead, starboard = place
    u, v, r = motion[:, 3], motion[:, 4], motion[:, 5]
    speed = np.hypot(u - r * starboard, v + r * ahead)
    at = int(speed.argmax())
    return float(speed[at]), round(motion[at, 9]) + 1


def sharpest(motion: Array) -> tuple[float, int]:
    """Greatest curvature of a route's motion, 1/m, and its waypoint, from 1."""
    under_way = motion[motion[:, 3] > _UNDER_WAY_MPS]
    curvature = np.abs(under_way[:, 5]) / under_way[:, 3]
    if curvature.size == 0 or curvature.max() == 0.0:
        return 0.0, 1
    at = int(curvature.argmax())
    return float(curvature[at]), round(under_way[at, 9]) + 1
