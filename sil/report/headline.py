# SPDX-License-Identifier: MIT
"""The verdict on a run in one line, for the top of its report and for the terminal."""

import math
from typing import Literal, NamedTuple

from sil.lockstep.metrics import BoatSummary, Summary

_COLOURS = {"good": "green", "fair": "yellow", "bad": "red"}
_SAILS = ("FORMATION", "COAST", "AUTO", "GUIDED", "LOITER", "RTL")


Level = Literal["good", "fair", "bad"]


class Verdict(NamedTuple):
    """A line of text, and its level.

    "bad": two boats came too near, a boat was in a state in which the law does not drive it, or its
    error was not finite. "fair": a boat does not stay in its slot to the end.
    """

    level: Level
    text: str

    @property
    def marked(self) -> str:
        """The line in its colour, as rich prints it."""
        return f"[bold {_COLOURS[self.level]}]{self.text}"


def of_run(summary: Summary) -> Verdict:
    """The verdict of a run.

    The time after which the boats stay in their slots is the longest settling time. Two boats are
    too near if their reference points come nearer than a hull's length.
    """
    boats = summary["boats"]
    wrong = [*_states(boats), *_separation(summary)]
    settled = [boat["settling_time_s"] for boat in boats if boat["settling_time_s"] is not None]
    in_slots = len(settled) == len(boats)
    parts = [f"{len(settled)} of {len(boats)} stay within 0.05 m of their slots"]
    if in_slots:
        parts[0] += f" from {max(settled):.0f} s on"
    worst = max(boats, key=lambda boat: _size(boat["max_error_m"]))
    if math.isfinite(worst["max_error_m"]):
        parts.append(f"worst {length(worst['max_error_m'])} in the last third")
    else:
        wrong.append(f"boat {worst['id']} has no finite error")
    least_m = summary["min_separation_m"]
    if least_m is not None:
        parts.append(f"closest two boats {least_m:.2f} m")
    level: Level = "bad" if wrong else "good" if in_slots else "fair"
    return Verdict(level, "; ".join([*parts, *wrong]))


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
