# SPDX-License-Identifier: MIT
"""A boat that waits: how well LOITER keeps a place, and with how much thrust.

    python -m tests.loop.waiting [--minutes 20]

The hull of `lead`, one propeller 15 % weak, in a current of 0.3 m/s: across its first
heading, alone and with 8 m/s of wind and gusts, and from astern.
"""

import argparse
from dataclasses import dataclass

import flotilla
import numpy as np
from rich.console import Console
from rich.progress import Progress

from sil.lockstep.batch import Batch
from sil.lockstep.policies import violations
from sil.scenario import scenario
from sil.wire.heartbeat import LOITER
from sil.wire.operator import ARM, mode_request

SETTLES_S = 60.0
CURRENT_MPS = 0.3
#: Weather by name; the bow points north when LOITER begins.
WEATHERS = {
    "current across": [f"water.current_mps=[0.0, {CURRENT_MPS}]"],
    "current, wind and gusts across": [
        f"water.current_mps=[0.0, {CURRENT_MPS}]",
        "wind.mean_mps=[0.0, 8.0]",
        "wind.gust_mps=1.0",
        "waves.height_m=0.1",
        "waves.course_rad=1.57",
    ],
    "current from astern": [f"water.current_mps=[{CURRENT_MPS}, 0.0]"],
    "current from the quarter": [
        f"water.current_mps=[{CURRENT_MPS * np.cos(0.5)}, {CURRENT_MPS * np.sin(0.5)}]"
    ],
}


@dataclass(frozen=True)
class Waited:
    """Metres from the place; both thrusts over those with the bow into the drift; bow off it."""

    mean_m: float
    worst_m: float
    thrust: float
    needed_N: float
    bow_rad: float
    state: str


def needed_N(one: scenario.Scenario) -> float:
    """Thrust that holds the hull against current and mean wind with its bow into them."""
    hull, speed = one.vessel, CURRENT_MPS
    wind_mps = float(np.hypot(*one.wind.mean_mps))
    air = 0.5 * 1.225 * hull.wind_x * hull.frontal_m2 * wind_mps**2
    return float(hull.d11 * speed + hull.d11_quadratic * speed**2 + air)


def wait(weather: str, minutes: float) -> Waited:
    """One run of that weather."""
    one = scenario.load("lead", WEATHERS[weather])
    one = one.model_copy(update={"boat": one.boat[:1]})
    batch = Batch([one], {})
    agent = batch.row(0, 1)
    h_s, t_us = 1e-6 * batch.h_us, 0
    ticks = round(60 * minutes / h_s)
    eta, thrust_N = np.zeros((ticks, 3)), np.zeros(ticks)
    tau = np.zeros((3, 1, 2))

    def sail(count: int) -> None:
        nonlocal t_us
        for _ in range(count):
            t_us += batch.h_us
            batch.tick(t_us)

    sail(800)
    batch.fleet.command([agent], t_us, *ARM)
    sail(100)
    batch.fleet.command([agent], t_us, *mode_request(LOITER))
    with Progress(console=Console(stderr=True), transient=True) as progress:
        for k in progress.track(range(ticks)):
            sail(1)
            eta[k] = batch.bodies.eta[agent]
            thrust_N[k] = np.abs(batch.command[0]).sum()
            batch.bodies.advance(batch.command, tau, h_s)
    assert not violations(batch), violations(batch)
    settled = round(SETTLES_S / h_s)
    off = np.hypot(*(eta[settled:, :2]).T)
    needed = needed_N(one)
    into = np.arctan2(*(-np.asarray(one.water.current_mps))[::-1])
    bow = np.angle(np.exp(1j * (eta[:, 2] - into)))
    state = flotilla.STATES[int(batch.states[0, 0])]
    full_N = one.propellers.forward_max_N
    return Waited(
        float(off.mean()),
        float(off.max()),
        full_N * float(thrust_N[settled:].mean()) / needed,
        needed,
        float(np.abs(bow[settled:]).max()),
        state,
    )


def main() -> None:
    """Wait in each weather, and print the rows of the page of measurements."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--minutes", type=float, default=20.0)
    given = parser.parse_args()
    print("| station of a 1.2 m hull | mean | worst | bow off | thrust over needed | needed |")
    for weather in WEATHERS:
        it = wait(weather, given.minutes)
        cells = f"{it.mean_m:.2f} m | {it.worst_m:.2f} m | {np.degrees(it.bow_rad):.0f}° | "
        cells += f"{it.thrust:.2f} | {it.needed_N:.1f} N"
        print(
            f"| {weather} | {cells} |" + ("" if it.state == "LOITER" else f" ended in {it.state}")
        )


if __name__ == "__main__":
    main()
