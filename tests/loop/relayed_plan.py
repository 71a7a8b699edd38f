# SPDX-License-Identifier: MIT
"""Boats in a line behind one that sails its plan; each hears its neighbours only, 0.2 s late.

    python -m tests.loop.relayed_plan [--boats 20] [--loss 0.3]

The hull, current and navigation of `lead`; legs of 40 and 20 m with square corners, 0.6 m/s. How
far each boat is from its slot of the plan, by its depth in the line.
"""

import argparse
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.progress import Progress

from sil.lockstep import metrics
from sil.lockstep.batch import Batch
from sil.lockstep.world import Run, all_sailed
from sil.lockstep.world import sail as sail_runs
from sil.plant.hull import Array
from sil.scenario import scenario
from sil.scenario.scenario import Scenario
from sil.wire.mavlink_frames import frames
from sil.wire.mavlink_messages import FORMATION_FUTURE, FORMATION_REFERENCE

SPACING_M = 4.0
DELAY_S = 0.2
LEARNS_S = 20.0
SIGNATURE = 13


@dataclass(frozen=True)
class Sailed:
    """Metres from the slot by depth, the leader's first; modes; signed bytes per second of boat 1.

    `told_Bps`: of FORMATION_FUTURE, FORMATION_REFERENCE.
    """

    rms_m: Array
    worst_m: Array
    states: list[dict[str, float]]
    told_Bps: tuple[float, float]

    @property
    def well(self) -> bool:
        """All followers were in FORMATION, but for a COAST of less than a second."""
        return all(
            set(one) <= {"FORMATION", "COAST"} and one.get("COAST", 0.0) < 1.0
            for one in self.states[1:]
        )


def line(boats: int, loss: float, duration_s: float) -> Scenario:
    """The scenario."""
    hops = range(3, boats + 1)
    chain = [f"boat.{boat}.follows={boat - 1}" for boat in hops]
    offsets = [f"boat.{boat}.offset_m=[{-SPACING_M}, 0.0]" for boat in hops]
    return scenario.load(
        "lead",
        [
            "formation.shape=column",
            f"formation.boats={boats}",
            f"formation.spacing_m={SPACING_M}",
            "leader.waypoints=[[0, 0], [40, 0], [40, 20], [0, 20]]",
            "leader.speed_mps=0.6",
            f"duration_s={duration_s}",
            f"link.delay_s={DELAY_S}",
            f"link.loss={loss}",
            "link.everyone=false",
            *chain,
            *offsets,
        ],
    )


def sail(boats: int = 20, loss: float = 0.0, duration_s: float = 150.0) -> Sailed:
    """One run."""
    told = {FORMATION_FUTURE: 0, FORMATION_REFERENCE: 0}

    def listen(batch: Batch, _members: object, _k: int, _t_us: int) -> None:
        for message_id, _, _, frame in frames(batch.fleet.sent(batch.leading(0))):
            if message_id in told:
                told[message_id] += len(frame) + SIGNATURE

    with Progress(console=Console(stderr=True), transient=True) as progress:
        task = progress.add_task("line", total=1.0)
        runs = sail_runs(
            [line(boats, loss, duration_s)],
            {},
            keep_s=0.1,
            progress=lambda share: progress.update(task, completed=share),
            watch=listen,
        )
    (run,) = all_sailed(runs)
    return judge(run, (told[FORMATION_FUTURE], told[FORMATION_REFERENCE]), duration_s)


def judge(run: Run, told: tuple[int, int], duration_s: float) -> Sailed:
    """The figures after the first 20 s, in which the boats learn the current and their thrust."""
    error = run.trace["error"][run.trace["t_s"] > LEARNS_S]
    off = metrics.distances(error)
    return Sailed(
        np.sqrt((off**2).mean(axis=0)),
        off.max(axis=0),
        run.states,
        (told[0] / duration_s, told[1] / duration_s),
    )


def main() -> None:
    """Sail without loss and with it, and print both by depth."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--boats", type=int, default=20)
    parser.add_argument("--loss", type=float, default=0.3)
    given = parser.parse_args()
    for loss in (0.0, given.loss):
        it = sail(given.boats, loss)
        print(f"{given.boats} boats, {100 * loss:.0f} % lost a hop: ≤ 0.1 m asked for")
        print("  RMS by depth (m):  ", " ".join(f"{cell:.3f}" for cell in it.rms_m))
        print("  worst by depth (m):", " ".join(f"{cell:.2f}" for cell in it.worst_m))
        print(f"  signed bytes a second of boat 1: {it.told_Bps[0]:.0f} of its future, ", end="")
        print(f"{it.told_Bps[1]:.0f} of the reference{'' if it.well else '; modes were left'}")


if __name__ == "__main__":
    main()
