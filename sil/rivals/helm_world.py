# SPDX-License-Identifier: MIT
"""Sails rivals in the plant of scenarios, with a helm in place of the firmware.

Sensors and propellers are the scenario's. A helm receives its unit's noisy states at the unit's
rate, as the firmware does. Its thrusts go to the same propellers by a command of 14 bits, as in a
RawCommand, and hold until its next state.
"""

from collections.abc import Callable, Sequence

import numpy as np

from sil.plant.hull import Array
from sil.plant.sensors import Sensors
from sil.rivals.helm import Helm, Known, Seen
from sil.scenario.fleet_bodies import bodies_of
from sil.scenario.scenario import Scenario
from sil.scenario.streams import SENSOR_STREAMS, generator

_FULL = 8191  # greatest value of a RawCommand
#: Makes the helms of a run's boats (None: it drifts), and a function called with all states.
Told = Callable[[list[Seen]], None]
Crew = Callable[[Scenario], tuple[Sequence[Helm | None], Told]]


def known_to_the_firmware(scenario: Scenario) -> Known:
    """The hull of boat 1 from its firmware's parameters."""
    own = scenario.firmware_parameters(scenario.boat[0])
    hull = {name: own[f"VES_{name.upper()}"] for name in ("m11", "m22", "m33", "d11", "d22", "d33")}
    most_N = min(own["THR_FWD_MAX"], own["THR_REV_MAX"])
    return Known(**hull, arm_m=own["THR_ARM"], most_N=most_N)


def sail(scenarios: Sequence[Scenario], crew: Crew, keep_s: float) -> list[Array]:
    """Poses (T, N, 3) of the boats of each run, every `keep_s` from the release on."""
    first = scenarios[0]
    bodies = bodies_of(scenarios)
    runs, boats = len(scenarios), len(first.boat)
    h_s, every = first.step_s, round(keep_s / first.step_s)
    look = round(1.0 / (first.navigation.rate_hz * h_s))
    rngs = [[generator(one.seed, stream) for one in scenarios] for stream in SENSOR_STREAMS]
    sensors = Sensors([one.navigation.noise for one in scenarios], rngs, bodies, h_s)
    crews = [crew(one) for one in scenarios]
    most = np.array([one.propeller_pairs()[0].forward_max_N for one in scenarios])
    command, tau = np.zeros((runs * boats, 2)), np.zeros((3, 1, 2))
    kept = np.zeros((runs, len(range(0, first.ticks, every)), boats, 3))
    for k in range(first.ticks):
        sensors.measure()
        if k % every == 0:
            kept[:, k // every] = bodies.eta[runs:].reshape(runs, boats, 3)
        if k % look == 0:
            eta = sensors.eta[runs:].tolist()
            nu = sensors.nu[runs:].tolist()
            for run, (helms, told) in enumerate(crews):
                rows = range(run * boats, (run + 1) * boats)
                seen = [Seen(k * h_s, *eta[row], *nu[row]) for row in rows]
                told(seen)
                for row, helm, state in zip(rows, helms, seen, strict=True):
                    if helm is not None:
                        share = np.clip(np.array(helm.steer(state)) / most[run], -1.0, 1.0)
                        command[row] = np.round(share * _FULL) / _FULL
        bodies.advance(command, tau, h_s)
    return list(kept)
