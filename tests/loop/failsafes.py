# SPDX-License-Identifier: MIT
"""Losses at random instants of a plan, whose failsafes end in LOITER or RTL.

    python -m tests.loop.failsafes --runs 1000

Boat 1 leads by its plan, two follow. Each run draws a hull, rates, a loss and its instant. Judged:
the policies; no thrust in HOLD, FAULT and DISARMED; the mode that the parameters name; no boat that
gives thrust goes on beyond the fence; a boat in RTL comes home and one in LOITER stays; nobody that
the loss does not concern leaves its mode. In some runs nothing is lost, but an operator pauses
boat 1, which must stay.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import flotilla
import numpy as np
from pymavlink.dialects.v20 import common as mavlink
from rich.console import Console
from rich.progress import track

from sil.lockstep.batch import Batch
from sil.lockstep.start import RunError
from sil.lockstep.world import Run, sail
from sil.plant.hull import Array
from sil.scenario import scenario
from sil.scenario.scenario import Scenario

BOATS, TOGETHER = 3, 100
DURATION_S, FIRST_S, LAST_S = 260.0, 20.0, 100.0
FENCE_M, BATTERY_V, GCS_S = 48.0, 14.0, 3.0
HOME_M, STAYS_M, BEYOND_M = 2.5, 2.5, 4.0
SETTLES_S = 60.0
#: A boat that was sent home later than this before the end need only be on its way, this fast
#: after it has turned; one that stops then is not judged by how it stays.
ARRIVES_S, TURNS_S, HOMEWARD_MPS = 120.0, 20.0, 0.3
STILL = {flotilla.STATES.index(name) for name in ("DISARMED", "HOLD", "FAULT")}
LOSSES = (
    "gcs",
    "battery",
    "leader",
    "fence",
    "navigation",
    "navigation for a moment",
    "navigation stuck",
    "navigation poor",
    "pause",
)
STOPS = ("LOITER", "RTL")
LEAD = 1


@dataclass(frozen=True)
class Drawn:
    """A run: the loss, the boat that suffers it (0: all), when, and the mode that it leads to."""

    seed: int
    loss: str
    boat: int
    at_s: float
    stop: str
    fence_m: float
    scenario: Scenario


def draw(seed: int) -> Drawn:
    """Run `seed`."""
    rng = np.random.default_rng(seed)
    loss = LOSSES[rng.integers(len(LOSSES))]
    stop = STOPS[rng.integers(2)]
    act = STOPS.index(stop) + 1
    boat = int(rng.integers(1, BOATS + 1))
    if loss == "gcs":
        boat = int(rng.integers(0, 2)) and boat
    if loss in ("leader", "fence", "pause"):
        boat = LEAD
    at_s = float(rng.uniform(FIRST_S, LAST_S))
    fence_m = float(rng.uniform(15.0, 34.0)) if loss == "fence" else FENCE_M
    heavier, drag = rng.uniform(0.7, 1.4, 2)
    overrides = [
        "formation.shape=vee",
        f"formation.boats={BOATS}",
        f"duration_s={DURATION_S}",
        f"seed={seed}",
        f"rate_hz={rng.choice([50.0, 100.0])}",
        f"navigation.rate_hz={rng.choice([10.0, 25.0, 50.0])}",
        f"link.delay_s={rng.choice([0.0, 0.1, 0.2])}",
        f"vessel.m11={24.0 * heavier}",
        f"vessel.m22={38.0 * heavier}",
        f"vessel.m33={5.5 * heavier}",
        f"vessel.d11={9.0 * drag}",
        f"propellers.stbd_gain={rng.uniform(0.85, 1.0)}",
        f"water.current_mps={[float(x) for x in rng.uniform(-0.1, 0.1, 2)]}",
        f"parameters.FS_GCS_S={GCS_S}",
        f"parameters.FS_GCS_ACT={act + 2}",
        f"parameters.FS_LEADER_ACT={act + 2}",
        f"parameters.FS_BATT_V={BATTERY_V}",
        f"parameters.FS_BATT_ACT={act}",
        f"parameters.FS_FENCE_M={fence_m}",
        f"parameters.FS_FENCE_ACT={act}",
        f"fault={faults(loss, boat, at_s, float(rng.uniform(0.7, 4.0)))}",
    ]
    return Drawn(seed, loss, boat, at_s, stop, fence_m, scenario.load("lead", overrides))


def faults(loss: str, boat: int, at_s: float, moment_s: float) -> str:
    """The scenario's faults, as its file would say them."""
    kind = {
        "gcs": "gcs_silent",
        "battery": "esc_voltage",
        "leader": "radio_silent",
        "navigation": "own_silent",
        "navigation for a moment": "own_silent",
        "navigation stuck": "own_stuck",
        "navigation poor": "own_poor_estimate",
    }.get(loss)
    if kind is None:
        return "[]"
    struck = range(1, BOATS + 1) if boat == 0 else [boat]
    more = f", value = {BATTERY_V - 2.0}" if kind == "esc_voltage" else ""
    if loss == "navigation for a moment":
        more = f", for_s = {moment_s}"
    tables = [f'{{kind = "{kind}", agent = {one}, at_s = {at_s}{more}}}' for one in struck]
    return f"[{', '.join(tables)}]"


class Watch:
    """States by tick of each run, and the greatest command given in a state without thrust.

    It also acts as the operator who pauses boat 1.
    """

    def __init__(self, drawn: Sequence[Drawn]) -> None:
        self.drawn = drawn
        self.states: list[list[Array]] = [[] for _ in drawn]
        self.pushed = np.zeros(len(drawn))

    def __call__(self, batch: Batch, members: Sequence[int], tick: int, t_us: int) -> None:
        """Note a tick."""
        given = np.abs(batch.command).max(axis=1).reshape(-1, batch.boats)
        still = np.isin(batch.states, list(STILL))
        for run, member in enumerate(members):
            self.states[member].append(batch.states[run].copy())
            most = float(np.where(still[run], given[run], 0.0).max())
            self.pushed[member] = max(self.pushed[member], most)
            one = self.drawn[member]
            if one.loss == "pause" and tick == round(one.at_s / one.scenario.step_s):
                batch.fleet.command(
                    [batch.row(run, one.boat)], t_us, mavlink.MAV_CMD_DO_PAUSE_CONTINUE, (0.0,)
                )


def expected(drawn: Drawn, boat: int) -> set[str]:
    """The modes in which a boat may end."""
    own = "AUTO" if boat == LEAD else "FORMATION"
    struck = drawn.boat in (0, boat)
    if drawn.loss == "leader":
        # Without its radio the leader has no ground station either.
        return {drawn.stop}
    if drawn.loss == "fence":
        return {drawn.stop} if boat == LEAD else {own, drawn.stop}
    if drawn.loss == "pause":
        return {own}
    if drawn.loss.startswith("navigation"):
        if struck:
            return {"HOLD"}
        # Without its state the leader is lost to those that follow it, unless it is soon back.
        followed = {own} if drawn.loss != "navigation" else set()
        return {drawn.stop} | followed if drawn.boat == LEAD else {own}
    return {drawn.stop} if struck else {own, drawn.stop} if drawn.boat == LEAD else {own}


def judge(drawn: Drawn, run: Run, states: Array, pushed: float) -> Iterator[str]:
    """A sentence for each error; none if all is well."""
    eta, t_s = run.trace["eta"][:, 1:, :2], run.trace["t_s"]
    if pushed > 0.0:
        yield f"thrust {pushed:.2f} in a state without"
    names = [flotilla.STATES[int(one)] for one in states[-1]]
    for boat, name in enumerate(names, start=1):
        if name not in expected(drawn, boat):
            yield f"boat {boat} ends in {name}, not {' or '.join(sorted(expected(drawn, boat)))}"
    home = eta[0]
    away_m = np.hypot(*(eta - home).transpose(2, 0, 1))
    at = np.searchsorted(np.arange(len(states)) * drawn.scenario.step_s, t_s, side="right") - 1
    drives = ~np.isin(states[at], list(STILL))
    beyond_m = np.where(drives, away_m, 0.0).max(axis=0) - drawn.fence_m
    for boat in map(int, np.flatnonzero(beyond_m > BEYOND_M)):
        yield f"boat {boat + 1} is {beyond_m[boat]:.1f} m beyond the fence under thrust"
    late = t_s > DURATION_S - SETTLES_S
    for boat, name in enumerate(names):
        # Followers of a leader that drifts in HOLD may reach the fence shortly before the end.
        others = np.flatnonzero(states[:, boat] != states[-1, boat])
        since_s = DURATION_S - drawn.scenario.step_s * (others[-1] if others.size else 0)
        farthest_m = HOME_M
        if since_s < ARRIVES_S:
            begun_m = away_m[np.searchsorted(t_s, DURATION_S - since_s) - 1, boat]
            farthest_m = max(HOME_M, begun_m - HOMEWARD_MPS * max(since_s - TURNS_S, 0.0))
        if name == "RTL" and away_m[-1, boat] > farthest_m:
            yield f"boat {boat + 1} in RTL ends {away_m[-1, boat]:.1f} m from home"
        roams_m = np.hypot(*(eta[late, boat] - eta[-1, boat]).T).max()
        paused = drawn.loss == "pause" and boat + 1 == drawn.boat
        stays = (name == "LOITER" and since_s >= ARRIVES_S) or paused
        if stays and roams_m > 2 * STAYS_M:
            yield f"boat {boat + 1} in {name} roams {roams_m:.1f} m"


@dataclass(frozen=True)
class Ended:
    """A run, the modes in which its boats ended, and what was wrong."""

    drawn: Drawn
    names: tuple[str, ...]
    wrong: tuple[str, ...]


def sail_all(seeds: Sequence[int]) -> list[Ended]:
    """Sail these runs together."""
    drawn = [draw(seed) for seed in seeds]
    watch = Watch(drawn)
    runs = sail([one.scenario for one in drawn], {}, keep_s=0.5, watch=watch)
    ended = []
    for i, (one, run) in enumerate(zip(drawn, runs, strict=True)):
        if isinstance(run, RunError):
            ended.append(Ended(one, (), (str(run),)))
            continue
        states = np.array(watch.states[i][-len_of(one) :])
        wrong = tuple(judge(one, run, states, watch.pushed[i]))
        ended.append(Ended(one, tuple(flotilla.STATES[int(s)] for s in states[-1]), wrong))
    return ended


def len_of(drawn: Drawn) -> int:
    """Ticks of a run."""
    return round(DURATION_S / drawn.scenario.step_s) + 1


def main() -> int:
    """Exit status 0 if nothing was wrong."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--first", type=int, default=1, help="seed of the first run")
    given = parser.parse_args()
    seeds = range(given.first, given.first + given.runs)
    ended: list[Ended] = []
    groups = [seeds[i : i + TOGETHER] for i in range(0, len(seeds), TOGETHER)]
    for group in track(groups, console=Console(stderr=True)):
        ended += sail_all(group)
        for one in ended[-len(group) :]:
            if one.wrong:
                drawn = f"seed {one.drawn.seed}, {one.drawn.loss} of boat {one.drawn.boat}"
                print(f"{drawn} at {one.drawn.at_s:.1f} s: {'; '.join(one.wrong)}", flush=True)
        print(f"{len(ended)} sailed", flush=True)
    kinds = Counter((one.drawn.loss, one.drawn.stop, bool(one.wrong)) for one in ended)
    for loss in LOSSES:
        cells = [f"{stop} {kinds[loss, stop, False]}" for stop in STOPS]
        failed = sum(kinds[loss, stop, True] for stop in STOPS)
        print(f"{loss}: {', '.join(cells)} as they must; {failed} not")
    wrong = sum(bool(one.wrong) for one in ended)
    print(f"{len(ended)} runs, seeds {seeds[0]} to {seeds[-1]}: {wrong} wrong")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
