# SPDX-License-Identifier: MIT
"""A fleet that boat 1 leads by its plan, along four routes: how well all sail it.

    python -m tests.loop.leading [--weather still|sea] [--position NOISE_M DRIFT_M]

The scenario `lead` with other waypoints: boat 1 gets its plan by MAVLink and sails it in AUTO,
three boats follow in a diamond. Truth is compared with the rounded plan, made by the same planner
alone.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.progress import Progress

from sil.lockstep import metrics
from sil.lockstep.world import Run, all_sailed
from sil.lockstep.world import sail as sail_runs
from sil.plant.hull import Array
from sil.rivals.routes import ROUTES, WEATHERS, arrival, scenarios_of
from sil.scenario.scenario import Scenario

LEARNS_S = 20.0
KEEP_S = 0.1
LEADER, FOLLOWER = {"AUTO"}, {"FORMATION"}


@dataclass(frozen=True)
class Sailed:
    """One route: metres, and shares.

    `mean_m`, `worst_m`: boat 1's distance from the rounded plan; `corner_m`: the worst within 5 m
    of a waypoint, without the first 20 s, in which the boat learns the current and its thrust;
    `cut_m`: greatest distance of the rounded plan from a waypoint; `speed`: the planned time over
    the time that it took; `rms_m`: the worst follower's distance from its slot; `closest`: least
    distance of two boats, as a share of that of their slots; `well`: all boats stayed in their
    modes.
    """

    mean_m: float
    worst_m: float
    corner_m: float
    cut_m: float
    speed: float
    rms_m: float
    closest: float
    well: bool


def sail(
    names: Sequence[str],
    weather: str = "still",
    position: tuple[float, float] = (0.02, 0.03),
    as_long_as: Sequence[str] = (),
) -> dict[str, Sailed]:
    """Sail these routes together, one run each, as long as the longest, also of `as_long_as`."""
    every = list(dict.fromkeys([*names, *as_long_as]))
    chosen = scenarios_of(every, weather, position)[: len(names)]
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(weather, total=1.0)
        runs = sail_runs(
            chosen, {}, keep_s=KEEP_S, progress=lambda share: progress.update(task, completed=share)
        )
    sailed = zip(names, chosen, all_sailed(runs), strict=True)
    return {name: judge(one, run) for name, one, run in sailed}


def judge(one: Scenario, run: Run) -> Sailed:
    """Compare a run with its rounded plan."""
    points = np.array(one.leader.waypoints)
    plan = one.route()
    plan = plan[: arrival(plan, len(points)) + 1]
    track = plan[::5, :2]
    t_s, eta, error = run.trace["t_s"], run.trace["eta"], run.trace["error"]
    end = points[-1]

    def near(places: Array) -> int:
        return int((np.hypot(*(places - end).T) < 0.5).argmax())

    there = near(eta[:, 1, :2]) or len(t_s)
    own = eta[:there, 1, :2]
    off = np.array([np.hypot(*(track - at).T).min() for at in own])
    at_corner = [np.hypot(*(points[1:-1] - at).T).min() < 5.0 for at in own]
    learnt = t_s[:there] > LEARNS_S
    error_m = metrics.distances(error[:there, 1:])[learnt]
    rms_m = np.sqrt((error_m**2).mean(axis=0))
    boats = range(1, eta.shape[1])
    apart = [np.hypot(*(eta[:, i, :2] - eta[:, j, :2]).T).min() for i in boats for j in range(1, i)]
    assert one.formation is not None
    well = all(
        set(states) == (FOLLOWER if boat else LEADER) for boat, states in enumerate(run.states)
    )
    return Sailed(
        float(off.mean()),
        float(off.max()),
        float(off[np.array(at_corner) & learnt].max()),
        float(max(np.hypot(*(track - corner).T).min() for corner in points[1:-1])),
        one.step_s * near(plan[:, :2]) / float(t_s[there]),
        float(rms_m.max()),
        float(min(apart)) / one.formation.spacing_m,
        well,
    )


def main() -> None:
    """Sail all routes and print the rows of the page of measurements."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--weather", choices=WEATHERS, default="still")
    parser.add_argument("--position", nargs=2, type=float, default=(0.02, 0.03))
    given = parser.parse_args()
    print("| route | mean | worst | at corners | rounded by | speed | followers | closest |")
    for name, it in sail(list(ROUTES), given.weather, tuple(given.position)).items():
        lengths = (it.mean_m, it.worst_m, it.corner_m, it.cut_m)
        cells = [f"{cell:.2f}" for cell in (*lengths, it.speed, it.rms_m, it.closest)]
        print("|", " | ".join([name, *cells, *([] if it.well else ["left its mode"])]), "|")


if __name__ == "__main__":
    main()
