# SPDX-License-Identifier: MIT
"""Fleets that leave a jetty far from their slots: how near two boats come, when all are in place.

    python -m tests.loop.jetty [HULL…] [--runs 40]

Four of a kind lie side by side, six hull lengths apart, in a random order. The jetty is 20 to 150 m
from the leader's start, in any direction, and the bows point anywhere. The fleets are those of
`tests.loop.presets`, in its weather, each boat behind the leader or behind the one before; all hear
each other over a radio that is 0.1 s late and loses 10 %. The boats are told their hull and
propellers, all else is the firmware's default.
"""

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.table import Table

from sil.lockstep import metrics
from sil.lockstep.start import StartError
from sil.lockstep.world import all_sailed, sail
from sil.scenario import presets, scenario
from sil.scenario.scenario import Scenario
from tests.loop.presets import BOATS, GUARD, WEATHER, alike, length_m

NEAREST_M, FARTHEST_M = 20.0, 150.0
DURATION_S = 500.0
ARRIVED_M = 0.5
RADIO = ("link.delay_s=0.1", "link.loss=0.1", "link.everyone=true")
_KEPT_S = 0.1


@dataclass(frozen=True)
class Outing:
    """`nearest`: of two boats, in guards. `arrived_s`: when the last one is in its slot and stays.

    `left`: a state other than FORMATION that ended a boat's approach.
    """

    nearest: float
    arrived_s: float
    left: str


def fleet(hull: str, number: int) -> Scenario:
    """Fleet `number` of a hull at its jetty; the same number draws the same start."""
    draws = np.random.default_rng([number, *hull.encode()])
    chain = bool(draws.integers(2))
    far_m, bearing = draws.uniform(NEAREST_M, FARTHEST_M), draws.uniform(0.0, 2.0 * math.pi)
    along, heading = draws.uniform(-math.pi, math.pi, 2)
    step_m = 6.0 * length_m(hull)
    places = [
        (boat.offset_m[0], boat.offset_m[1]) for boat in scenario.load("mixed", alike(hull)).boat
    ]
    changes = []
    for berth, boat in enumerate(draws.permutation(BOATS)):
        off_m = step_m * (berth - 0.5 * (BOATS - 1))
        north = far_m * math.cos(bearing) + off_m * math.cos(along)
        east = far_m * math.sin(bearing) + off_m * math.sin(along)
        ahead = places[boat - 1] if chain and boat > 0 else (0.0, 0.0)
        offset = [place - other for place, other in zip(places[boat], ahead, strict=True)]
        changes += [
            f"boat.{boat + 1}.eta=[{north:.2f}, {east:.2f}, {heading:.3f}]",
            f"boat.{boat + 1}.follows={boat if chain else 0}",
            f"boat.{boat + 1}.offset_m={offset}",
        ]
    more = [*WEATHER, *RADIO, f"duration_s={DURATION_S}", f"seed={number}"]
    return scenario.load("mixed", [*alike(hull), *more, *changes])


def outings(hull: str, numbers: Sequence[int]) -> list[Outing]:
    """The outings of these fleets of a hull, without those that do not start.

    A fleet starts with its hulls held in place while the positions vary by noise. With full thrust
    towards far slots, boats find within 0.3 s that they do not respond, and a boat behind them that
    its leader's state is frozen. Of fleets 1 to 39, one of the paper's vessel does not start.
    """
    found = []
    fleets = [fleet(hull, number) for number in numbers]
    runs = sail(fleets, {}, keep_s=_KEPT_S)
    for run in all_sailed(run for run in runs if not isinstance(run, StartError)):
        off = metrics.distances(run.trace["error"]).max(axis=1)
        late = np.flatnonzero(off > ARRIVED_M)
        left = [state for states in run.states for state in states if state != "FORMATION"]
        found.append(
            Outing(
                (metrics.min_separation_m(run.trace["eta"]) or 0.0) / (GUARD * length_m(hull)),
                _KEPT_S * float(late[-1] + 1) if late.size else 0.0,
                left[0] if left else "",
            )
        )
    return found


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("hull", nargs="*", default=presets.names())
    parser.add_argument("--runs", type=int, default=40, metavar="N", help="fleets of each hull")
    given = parser.parse_args(arguments)
    table = Table(
        *(
            "hull",
            "fleets that started",
            "nearest two, guards",
            "nearer than 1",
            "in place: median, 95 %, s",
            "left",
        )
    )
    for hull in given.hull:
        found = outings(hull, range(given.runs))
        nearest = [each.nearest for each in found]
        median_s, late_s = np.quantile([each.arrived_s for each in found], (0.5, 0.95))
        table.add_row(
            hull,
            f"{len(found)} of {given.runs}",
            f"{min(nearest):.2f}",
            str(sum(each < 1.0 for each in nearest)),
            f"{median_s:.0f}, {late_s:.0f}",
            str(sum(bool(each.left) for each in found)),
        )
    Console().print(table)


if __name__ == "__main__":
    main()
