# SPDX-License-Identifier: MIT
"""Four routes and two weathers, in which boats that lead and their rivals are compared.

The routes are like those of Kyyrron/BlueBoat-Control (2026): a sine of 132 m, a square of 174.5 m,
a lawnmower pattern of 228 m, sharp angles of 155.6 m.
"""

import math
from collections.abc import Sequence

from sil.plant.hull import Array
from sil.scenario import scenario
from sil.scenario.scenario import Scenario

STOPS_S = 15.0  # time that a run lasts beyond its plan

Place = tuple[float, float]


def sine() -> list[Place]:
    """132 m: two waves of 3 m."""
    return [(float(x), 3.0 * math.sin(2 * math.pi * x / 60.0)) for x in range(0, 121, 6)]


def square() -> list[Place]:
    """Three sides and a half of 50 m."""
    return [(0, 0), (50, 0), (50, 50), (0, 50), (0, 25.5)]


def lawnmower() -> list[Place]:
    """Four tracks of 50 m, 10 m apart."""
    return [(0, 0), (50, 0), (50, 10), (0, 10), (0, 20), (50, 20), (50, 30), (0, 30)]


def sharp() -> list[Place]:
    """Turns of 120° and more."""
    return [(0, 0), (40, 0), (10, 17), (50, 25), (20, 42), (40, 52)]


#: Waypoints, and the speed in m/s.
ROUTES: dict[str, tuple[list[Place], float]] = {
    "sine": (sine(), 0.5),
    "square": (square(), 0.5),
    "lawnmower": (lawnmower(), 0.5),
    "sharp angles": (sharp(), 0.7),
}
WEATHERS = {
    "still": ["water.current_mps=[0.07, 0.07]"],
    "sea": [
        "water.current_mps=[0.21, 0.21]",
        "wind.mean_mps=[-5.6, 5.6]",
        "wind.gust_mps=1.0",
        "waves.height_m=0.1",
        "waves.course_rad=2.36",
    ],
}


def scenarios_of(
    names: Sequence[str],
    weather: str,
    position: tuple[float, float] = (0.02, 0.03),
    seed: int = 1,
) -> list[Scenario]:
    """The scenario `lead` along these routes, all with the duration of the longest.

    `position`: standard deviations of noise and drift, m.
    """

    def one(name: str, duration_s: float) -> Scenario:
        points, speed_mps = ROUTES[name]
        return scenario.load(
            "lead",
            [
                f"leader.waypoints={[list(point) for point in points]}",
                f"leader.speed_mps={speed_mps}",
                f"navigation.position_noise_m={position[0]}",
                f"navigation.position_drift_m={position[1]}",
                f"duration_s={duration_s}",
                f"seed={seed}",
                *WEATHERS[weather],
            ],
        )

    ends = []
    for name in names:
        chosen = one(name, 900.0)
        ends.append(chosen.step_s * arrival(chosen.route(), len(ROUTES[name][0])))
    return [one(name, max(ends) + STOPS_S) for name in names]


def arrival(plan: Array, points: int) -> int:
    """The sample of a plan's motion at which it arrives; the last one if it does not."""
    there = plan[:, 9] >= points
    return int(there.argmax()) if there.any() else len(plan) - 1
