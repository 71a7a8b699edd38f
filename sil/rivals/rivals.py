# SPDX-License-Identifier: MIT
"""The rivals, and their gains.

Gains are the best of a grid, by the mean distance over all routes in calm weather with seed 2. The
published runs have seed 1, so that no rival is tuned to the runs by which it is judged. Flotilla
was not tuned on these routes: it has the gains of `lead`, which sets LAW_KDU, LAW_KDR, LAW_XT_DIST
and LAW_R_MAX; the others are defaults.
"""

import math
from collections.abc import Sequence
from itertools import product

import numpy as np

from sil.lockstep.world import all_sailed
from sil.lockstep.world import sail as sail_flotilla
from sil.rivals import helm_world, line_of_sight, rover
from sil.rivals.helm import Helm, Seen
from sil.rivals.judge import Figures, figures
from sil.rivals.path import Path
from sil.rivals.routes import arrival, scenarios_of
from sil.scenario.scenario import Scenario

KEEP_S = 0.1
OURS = "Flotilla"
TUNED_WITH = 2  # seed of the tuning runs
_RADIO_S = 0.1  # time between two of the leader's positions

Gains = tuple[float, ...]
GAINS: dict[str, Gains] = {
    "ILOS": (0.4, 0.1, 4.0),
    "ALOS": (0.4, 0.4, 4.0),
    "Rover": (0.5, 1.5, 1.0),
    "NMPC": (80.0, 0.02),
}
GRID: dict[str, tuple[tuple[float, ...], ...]] = {
    "ILOS": ((0.4, 0.6, 1.0), (0.1, 0.2, 0.4), (2.0, 3.0, 4.0)),
    "ALOS": ((0.4, 0.6, 1.0), (0.1, 0.2, 0.4), (2.0, 3.0, 4.0)),
    "Rover": ((0.2, 0.5, 1.0), (0.5, 1.0, 1.5), (0.2, 0.5, 1.0)),
    "NMPC": ((5.0, 20.0, 80.0), (0.02,)),
}
RIVALS = tuple(GAINS)


def crew_of(name: str, gains: Gains) -> helm_world.Crew:
    """The helms of a rival: for boat 1, and with Rover's Follow for the boats behind it."""

    def crew(one: Scenario) -> tuple[Sequence[Helm | None], helm_world.Told]:
        known = helm_world.known_to_the_firmware(one)
        plan = one.route()
        path = Path(plan[: arrival(plan, len(one.leader.waypoints)) + 1], one.step_s)
        alone: list[Helm | None] = [None] * (len(one.boat) - 1)
        if name == "Rover":
            return _rovers(one, rover.on_path(path), rover.Gains(*gains))
        if name == "NMPC":
            from sil.rivals.mpc import Mpc  # noqa: PLC0415 CasADi comes with an extra

            return [Mpc(known, path, *gains), *alone], _nobody
        los = line_of_sight.Gains(*gains)
        return [line_of_sight.LineOfSight(known, path, los, adapts=name == "ALOS"), *alone], _nobody

    return crew


def _nobody(_: list[Seen]) -> None:
    """Ignore the states: no boat receives them."""


def _rovers(
    one: Scenario, target: rover.Aim, gains: rover.Gains
) -> tuple[Sequence[Helm | None], helm_world.Told]:
    known = helm_world.known_to_the_firmware(one)
    rng = np.random.default_rng(one.seed)
    heard = [
        rover.Heard(one.link.delay_s, lambda: rng.random() < one.link.loss, _RADIO_S)
        for _ in one.boat[1:]
    ]
    helms = [rover.Rover(known, target, gains)]
    for boat, ear in zip(one.boat[1:], heard, strict=True):
        helms.append(rover.Rover(known, ear.follow(boat.offset_m), gains))

    def told(seen: list[Seen]) -> None:
        for ear in heard:
            ear.say(seen[0])

    return helms, told


def sail(
    name: str,
    routes: Sequence[str],
    weather: str,
    *,
    seed: int = 1,
    gains: Gains | None = None,
    most_s: float = math.inf,
) -> dict[str, Figures]:
    """Sail a rival, or Flotilla, along routes; `most_s`: limit of the duration, for a test."""
    scenarios = scenarios_of(routes, weather, seed=seed)
    longest_s = min(most_s, scenarios[0].duration_s)
    scenarios = [one.model_copy(update={"duration_s": longest_s}) for one in scenarios]
    is_fleet = name in (OURS, "Rover")
    if name == OURS:
        runs = all_sailed(sail_flotilla(scenarios, {}, keep_s=KEEP_S))
        eta = [run.trace["eta"][:, 1:] for run in runs]
    else:
        eta = helm_world.sail(scenarios, crew_of(name, gains or GAINS[name]), KEEP_S)
    judged = zip(routes, scenarios, eta, strict=True)
    return {route: figures(one, run, KEEP_S, fleet=is_fleet) for route, one, run in judged}


def tune(name: str, routes: Sequence[str]) -> list[tuple[float, Gains]]:
    """Mean distance over the routes, m, of every point of the grid, the best first."""
    found = []
    for gains in product(*GRID[name]):
        told = sail(name, routes, "still", seed=TUNED_WITH, gains=gains).values()
        well = all(one.speed > 0.0 for one in told)
        mean_m = sum(one.mean_m for one in told) / len(routes)
        found.append((mean_m if well else math.inf, gains))
    return sorted(found)
