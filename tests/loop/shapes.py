# SPDX-License-Identifier: MIT
"""Fleets that change their shape while they sail a plan.

    python -m tests.loop.shapes [--changes 500] [--seed 1] [--boats N…] [--hull NAME]

The scenario `lead` with 4 to 20 boats on a radio that loses 10 % and is up to 0.2 s late. A ground
station asks for a random shape and spacing, again and again; the boat that hears it gives the
places to the members. Truth is judged: how near two boats come, and when all are in their places.
With the hull of another preset, at its cruise, plan and shapes scale with the hull's length.
"""

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import get_args

import flotilla
import numpy as np
from rich.console import Console
from rich.progress import Progress

from sil.fleet.shape_change import SLOTS_GUARDS
from sil.lockstep.batch import Batch
from sil.lockstep.start import RunError
from sil.lockstep.world import sail as sail_runs
from sil.plant.hull import Array
from sil.scenario import presets, scenario
from sil.scenario.formation import Formation, Place, Shape, slots
from sil.scenario.scenario import Scenario
from sil.wire.fleet_table import Member, table_message

FIRST_S, EVERY_S, EACH = 20.0, 200.0, 5  # when shapes of `lead` change, and how many times in a run
U_MAX_MPS, R_MAX_RADPS = 1.5, 0.8  # r_max of a short hull
LONG_M = 1.3  # longer hulls turn more slowly, see LAW_R_MAX
NEAR_M, STAY_S = 0.3, 5.0  # of a boat of `lead` that has arrived: how near its place, for how long
COURSE_S = 2.0  # of boat 1, before and after an instant, that give its course
STEP_S = 0.2  # of what is noted
SPARE_S = 10.0  # added to an intercept and a turn
RADIO = 1
TURNING = 4  # a shape of so many boats turns with its leader; greater ones keep their bearings
ROUTE_M = ((0.0, 0.0), (170.0, 0.0), (170.0, 170.0), (0.0, 170.0), (0.0, 0.0))
CORNER_M, WP_RADIUS_M, SPEED_MPS = 20.0, 1.5, 0.6
SPACING_M = 5.0  # at the start
GUARD_M = 1.44  # FS_SEP_M of boats of `lead`
SPACINGS_M = round(SLOTS_GUARDS * GUARD_M + 0.05, 1), 6.0  # from the least that a command forms
SETTINGS = (
    "link.delay_s=0.1",
    "link.jitter_s=0.1",
    "link.loss=0.1",
    "link.everyone=true",
)


@dataclass(frozen=True)
class Change:
    """One change of shape: `nearest_m` of two boats, until the next one begins.

    `arrived_s`: when all boats have come within NEAR_M of their places and stay there for STAY_S;
    `asked_s`: a time-optimal intercept of the places, as they moved behind boat 1, one turn and
    10 s; both since the request. `far_m`: the longest way in the shape; `later_m`: the farthest
    boat from its place after they have arrived, as in the leader's next corner; `off_m`: the same
    at the end; `idle`: boats that are in neither AUTO nor FORMATION at the end.
    """

    boats: int
    shape: str
    spacing_m: float
    far_m: float
    nearest_m: float
    arrived_s: float
    asked_s: float
    later_m: float
    off_m: float
    idle: int


@dataclass(frozen=True)
class Wish:
    """A shape that a ground station asks for, with its places."""

    shape: str
    spacing_m: float
    places: list[Place]


class Observer:
    """Asks for the shapes of each run, and notes where the boats are, five times a second."""

    def __init__(self, one: Scenario, wishes: Sequence[Sequence[Wish]]) -> None:
        self.one, self.wishes = one, wishes
        self.every = round(STEP_S / one.step_s)
        self.eta: list[list[Array]] = [[] for _ in wishes]
        self.states: list[Array] = [np.zeros(0, int) for _ in wishes]

    def __call__(self, batch: Batch, members: Sequence[int], k: int, t_us: int) -> None:
        first, every = (round(x / self.one.step_s) for x in (FIRST_S, every_s(self.one)))
        for run, member in enumerate(members):
            rows = list(batch.agents(run))
            if k == 0 and self.one.formation:
                first_table = self._table(1, slots(self.one.formation))
                batch.fleet.hear(rows[0], first_table, t_us, RADIO)
            number, rest = divmod(k - first, every)
            if rest == 0 and 0 <= number < EACH:
                wish = self.wishes[member][number]
                told = self._table(number + 2, wish.places, assign=True)
                batch.fleet.hear(rows[0], told, t_us, RADIO)
            if k % self.every == 0:
                self.eta[member].append(batch.bodies.eta[rows].copy())
                self.states[member] = np.array(batch.states[run])

    def _table(self, epoch: int, places: Sequence[Place], *, assign: bool = False) -> bytes:
        members = [
            Member(i + 1, min(i, 1), place, self.one.vessel.length_m)
            for i, place in enumerate(places)
        ]
        turns = self.one.formation is not None and self.one.formation.turns
        return table_message(epoch, members, turns=turns, assign=assign, in_s=1.0)


def fleet(boats: int, *, turns: bool, hull: str = "") -> Scenario:
    """A fleet of `lead`'s boats or of another hull; the route scales with the hull's length."""
    own = presets.load(hull) if hull else None
    times = size_of(own.vessel.length_m) if own else 1.0
    speed_mps = own.cruise.speed_mps if own else SPEED_MPS
    slower = max(times * SPEED_MPS / speed_mps, 1.0)
    base = scenario.load(
        "lead",
        [
            *SETTINGS,
            f"duration_s={FIRST_S + EACH * slower * EVERY_S}",
            f"leader.waypoints={[[times * x, times * y] for x, y in ROUTE_M]}",
            f"leader.corner_radius_m={times * CORNER_M}",
            f"formation.boats={boats}",
            f"formation.spacing_m={times * SPACING_M}",
            f"formation.shape={'vee' if turns else 'column'}",
            f"formation.turns={str(turns).lower()}",
            f"leader.speed_mps={speed_mps}",
        ],
    )
    if own is None:
        return base
    told = {**base.parameters, **presets.firmware(own), "WP_RADIUS": times * WP_RADIUS_M}
    parts = {"vessel": own.vessel, "propellers": own.propellers, "parameters": told}
    return base.model_copy(update=parts)


def every_s(one: Scenario) -> float:
    """Time between two changes."""
    return (one.duration_s - FIRST_S) / EACH


def size_of(length_m: float) -> float:
    """Length of a hull relative to `lead`'s, at least 1."""
    return max(length_m / scenario.load("lead").vessel.length_m, 1.0)


def drawn(generator: np.random.Generator, boats: int, times: float = 1.0) -> Wish:
    """A random shape for this many boats, `times` as large as for those of `lead`."""
    while True:
        shape: Shape = generator.choice(get_args(Shape))
        spacing_m = round(float(generator.uniform(*SPACINGS_M)), 1)
        try:
            places = slots(Formation(shape=shape, boats=boats, spacing_m=spacing_m))
        except ValueError:
            continue  # a diamond of five
        x0, y0 = places[0]
        moved = [(times * (x - x0), times * (y - y0)) for x, y in places]
        return Wish(shape, times * spacing_m, moved)


def intercepted_s(places: Array, starts: Array) -> float:
    """Until boats at U_MAX_MPS can all be at places that move: (times, boats, 2), (boats, 2)."""
    away = places - starts
    reach = U_MAX_MPS * STEP_S * np.arange(len(places))
    met = np.hypot(away[..., 0], away[..., 1]) <= reach[:, None] + 1e-9
    return float(STEP_S * met.argmax(axis=0).max()) if met.any(axis=0).all() else np.inf


def nearest_m(eta: Array) -> float:
    """Least distance of two boats in (times, boats, 3)."""
    a, b = np.triu_indices(eta.shape[1], 1)
    apart = eta[:, a, :2] - eta[:, b, :2]
    return float(np.hypot(apart[..., 0], apart[..., 1]).min())


def velocity_of(eta: Array) -> Array:
    """Boat 1's mean over ground, m/s, from COURSE_S before an instant to COURSE_S after it.

    A mean over the past alone would lag in a turn, by 0.4 m at the far end of a line of four boats.
    (times, 2)
    """
    size, last = round(COURSE_S / STEP_S), len(eta) - 1
    before = np.clip(np.arange(-size, last - size + 1), 0, last)
    after = np.clip(np.arange(size, last + size + 1), 0, last)
    v: Array = (eta[after, 0, :2] - eta[before, 0, :2]) / (STEP_S * (after - before)[:, None])
    return v


def in_shape(off: Array, v: Array, *, turns: bool) -> Array:
    """(times, boats, 2), north and east; ahead and to starboard of the course where it turns."""
    if not turns:
        return off
    course = np.arctan2(v[:, 1], v[:, 0])[:, None]
    c, s = np.cos(course), np.sin(course)
    return np.stack([c * off[..., 0] + s * off[..., 1], c * off[..., 1] - s * off[..., 0]], -1)


def from_shape(off: Array, v: Array, *, turns: bool) -> Array:
    """Inverse of `in_shape`."""
    return in_shape(off, v * (1.0, -1.0), turns=turns)


def reached(end: Array, told: Array) -> tuple[Array, float]:
    """Which place each boat took, (boats, 2), and the farthest boat's distance from it.

    Any boat may have any place, the leader too. Infinite where two boats are nearest to one.
    """
    best = told, np.inf
    for root in told:
        goals = told - root
        apart = end[:, None] - goals[None]
        distance = np.hypot(apart[..., 0], apart[..., 1])
        chosen = distance.argmin(axis=1)
        if len(set(chosen)) == len(told) and distance.min(axis=1).max() < best[1]:
            best = goals[chosen], float(distance.min(axis=1).max())
    return best


def judge(wish: Wish, eta: Array, states: Array, *, turns: bool, length_m: float = 0.0) -> Change:
    """`eta`: (times, boats, 3), from the request to the next one."""
    near_m = NEAR_M * size_of(length_m)
    turn_s = 2.0 * np.pi / R_MAX_RADPS * max(length_m / LONG_M, 1.0)
    v = velocity_of(eta)
    place = in_shape(eta[..., :2] - eta[:, :1, :2], v, turns=turns)
    goals, off_m = reached(place[-1], np.array(wish.places))
    to = place - goals
    far = np.hypot(to[..., 0], to[..., 1]).max(axis=1)
    stay = round(STAY_S / STEP_S)
    still = np.flatnonzero(np.convolve(far > near_m, np.ones(stay), "valid") == 0)
    first = int(still[0]) if len(still) else len(far)
    places = eta[:, :1, :2] + from_shape(np.broadcast_to(goals, place.shape), v, turns=turns)
    sails = [flotilla.STATES.index(state) for state in ("AUTO", "FORMATION")]
    return Change(
        boats=len(goals),
        shape=wish.shape,
        spacing_m=wish.spacing_m,
        far_m=float(far[0]),
        nearest_m=nearest_m(eta),
        arrived_s=STEP_S * first if len(still) else np.inf,
        asked_s=intercepted_s(places, eta[0, :, :2]) + turn_s + SPARE_S,
        later_m=float(far[first:].max(initial=0.0)) if len(still) else np.inf,
        off_m=off_m,
        idle=int((~np.isin(states, sails)).sum()),
    )


def sail(boats: int, runs: int, seed: int, *, turns: bool, hull: str = "") -> list[Change]:
    """EACH changes in each of so many runs of a fleet."""
    base = fleet(boats, turns=turns, hull=hull)
    length_m = base.vessel.length_m
    chosen = [base.model_copy(update={"seed": seed + run}) for run in range(runs)]
    generator = np.random.default_rng([seed, boats, turns])
    times = size_of(length_m)
    wishes = [[drawn(generator, boats, times) for _ in range(EACH)] for _ in range(runs)]
    observer = Observer(base, wishes)
    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task(f"{boats} boats", total=1.0)
        done = sail_runs(
            chosen,
            {},
            keep_s=1.0,
            progress=lambda share: progress.update(task, completed=share),
            watch=observer,
        )
    for it in done:
        if isinstance(it, RunError):
            raise it
    changes = []
    for run in range(runs):
        eta = np.array(observer.eta[run])
        for number, wish in enumerate(wishes[run]):
            begin, end = (round((FIRST_S + (number + i) * every_s(base)) / STEP_S) for i in (0, 1))
            part = eta[begin : min(end, len(eta))]
            states = observer.states[run]
            changes.append(judge(wish, part, states, turns=turns, length_m=length_m))
    return changes


def main() -> None:
    """Sail fleets of all sizes and print a line for each change, the summary last."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--changes", type=int, default=500)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--hull", choices=presets.names(), default="")
    parser.add_argument("--boats", nargs="+", type=int, default=[4, 6, 8, 9, 12, 16, 20])
    given = parser.parse_args()
    runs = max(1, math.ceil(given.changes / EACH / len(given.boats)))
    names = ("boats", "shape", "spacing", "longest way", "nearest two", "arrived", "asked")
    print("|", " | ".join([*names, "later", "off", "idle"]), "|")
    changes = []
    for boats in given.boats:
        for it in sail(boats, runs, given.seed, turns=boats == TURNING, hull=given.hull):
            changes.append(it)
            times, off = [it.arrived_s, it.asked_s], [it.later_m, it.off_m]
            figures = [it.spacing_m, it.far_m, it.nearest_m, *times, *off]
            cells = [str(it.boats), it.shape, *(f"{x:.2f}" for x in figures), str(it.idle)]
            print("|", " | ".join(cells), "|", flush=True)
    late = sum(it.arrived_s > it.asked_s for it in changes)
    print(
        f"{len(changes)} changes: nearest two {min(it.nearest_m for it in changes):.2f} m, "
        f"{sum(not np.isfinite(it.arrived_s) for it in changes)} did not arrive, {late} too late"
    )


if __name__ == "__main__":
    main()
