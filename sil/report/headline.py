# SPDX-License-Identifier: MIT
"""The verdict on a run in one line, for the top of its report and for the terminal."""

import math
from typing import Literal, NamedTuple

from sil.lockstep.metrics import SETTLED_M, BoatSummary, PlanEnd, Summary

_COLOURS = {"good": "green", "fair": "yellow", "bad": "red"}
IN_SLOT_M = 0.2
_SAILS = ("FORMATION", "COAST", "AUTO", "GUIDED", "LOITER", "RTL")


Level = Literal["good", "fair", "bad"]


class Verdict(NamedTuple):
    """A line of text, and its level.

    "bad": two boats came too near, a boat was in a state in which the law does not drive it, or its
    error was not finite. "fair": a boat was farther than `IN_SLOT_M` from its slot in the last
    third of the run, or the plan of a boat that leads was not over.
    """

    level: Level
    text: str

    @property
    def marked(self) -> str:
        """The line in its colour, as rich prints it."""
        return f"[bold {_COLOURS[self.level]}]{self.text}"


def of_run(summary: Summary) -> Verdict:
    """The verdict of a run.

    If all boats settle before the last third, the verdict gives the longest settling time.
    Otherwise it counts the boats that stay within `IN_SLOT_M` of their slots in the last third. Two
    boats are too near if their reference points come nearer than a hull's length.
    """
    boats = summary["boats"]
    wrong = [*_states(boats), *_separation(summary)]
    if "voyage" in summary:
        over = summary["voyage"]
        text = over or f"the voyage was not over after {summary['duration_s']:g} s"
        return Verdict("bad" if wrong else "good" if over else "fair", "; ".join([text, *wrong]))
    plan = summary.get("plan")
    over_s = None if plan is None else plan["over_s"]
    early_s = 2.0 / 3.0 * (over_s or summary["duration_s"])
    settling = [boat["settling_time_s"] for boat in boats]
    settled = [s for s in settling if s is not None and s <= early_s]
    if len(settled) == len(boats):
        near_m, since = SETTLED_M, f" from {max(settled):.0f} s on"
    else:
        near_m, since = IN_SLOT_M, ""
    near = [boat for boat in boats if boat["max_error_m"] <= near_m]
    in_slots = len(near) == len(boats)
    parts = [f"{len(near)} of {len(boats)} stay within {near_m:g} m of their slots{since}"]
    worst = max(boats, key=lambda boat: _size(boat["max_error_m"]))
    if math.isfinite(worst["max_error_m"]):
        parts.append(f"worst {length(worst['max_error_m'])} in the last third")
    else:
        wrong.append(f"boat {worst['id']} has no finite error")
    least_m = summary["min_separation_m"]
    if least_m is not None:
        parts.append(f"closest two boats {least_m:.2f} m")
    if plan is not None:
        parts.append(_plan(plan))
    done = plan is None or over_s is not None
    level: Level = "bad" if wrong else "good" if in_slots and done else "fair"
    return Verdict(level, "; ".join([*parts, *wrong]))


def _plan(plan: PlanEnd) -> str:
    if plan["over_s"] is None:
        return f"boat 1's plan was not over: still on item {plan['item']} of {plan['items']}"
    over = f"boat 1's plan was over after {plan['over_s']:.0f} s"
    waiting_m = plan["waiting_m"]
    return over if waiting_m is None else f"{over}, then all waited within {length(waiting_m)}"


def _states(boats: list[BoatSummary]) -> list[str]:
    told = []
    for boat in boats:
        lost = {name: s for name, s in boat["states"].items() if name not in _SAILS and s > 0.0}
        if lost:
            seconds = ", ".join(f"{s:.1f} s in {name}" for name, s in lost.items())
            told.append(f"boat {boat['id']} was {seconds}")
    return told


def _separation(summary: Summary) -> list[str]:
    least_m, hull_m = summary["min_separation_m"], summary["hull_m"]
    # "not at least" rather than "under": NaN counts as too near
    if least_m is None or least_m >= hull_m:
        return []
    return [f"two boats came nearer than a hull's length ({hull_m:g} m)"]


class Ended(NamedTuple):
    """Numbers of a campaign's runs by their end; a run can be both settled and too near.

    `settled`: every boat stays within 0.05 m of its slot to the end. `near`: two boats' reference
    points came nearer than the length of the longest hull, `hull_m`; None if runs have one boat
    each.
    """

    runs: int
    settled: int
    near: int | None
    diverged: int
    failed: int
    hull_m: float


def of_campaign(ended: Ended) -> Verdict:
    """The verdict of a campaign."""
    parts = [f"{ended.settled} of {ended.runs} runs settled"]
    if ended.near is not None:
        which = f"in {ended.near} two boats came" if ended.near else "in none did two boats come"
        parts.append(f"{which} nearer than a hull's length ({ended.hull_m:g} m)")
    parts += [f"{ended.diverged or 'none'} diverged", f"{ended.failed or 'none'} failed"]
    bad = (ended.near or 0) + ended.diverged + ended.failed > 0
    level: Level = "bad" if bad else "good" if ended.settled == ended.runs else "fair"
    return Verdict(level, "; ".join(parts))


def length(metres: float) -> str:
    """A distance as text; short distances are in millimetres."""
    return f"{1000.0 * metres:.1f} mm" if metres < 0.01 else f"{metres:.2f} m"


def _size(metres: float) -> float:
    return math.inf if math.isnan(metres) else metres
