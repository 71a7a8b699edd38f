# SPDX-License-Identifier: MIT
"""The plant of scenarios: builds bodies, and the forces on them, from keys and seeds."""

from collections.abc import Sequence

import numpy as np

from sil.plant import hull, propeller
from sil.plant.bodies import Bodies
from sil.plant.hull import HullParameters
from sil.plant.waves import Sea, WaveBody, Waves
from sil.plant.weather import Force, Weather, WhiteNoise
from sil.plant.wind import Gusts, Wind, Windage
from sil.scenario.scenario import Scenario, Vessel
from sil.scenario.streams import Stream, generator

_BECALMED = Windage(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


def bodies_of(scenarios: Sequence[Scenario]) -> Bodies:
    """The bodies of all agents in their initial state; all scenarios have the same number of boats.

    The virtual leader is a reference: only its input acts on it, and its hull is nominal.
    """
    leaders = [one.leader for one in scenarios]
    boats = [boat for one in scenarios for boat in one.boat]
    water = [one.water.current_mps for one in scenarios]
    hulls = [hulls_of(one) for one in scenarios]
    afloat = [run[1:] for run in hulls]
    forces = _forces_of(scenarios, afloat)
    return Bodies(
        hull.stack([*(run[0] for run in hulls), *(body for run in afloat for body in run)]),
        propeller.stack(pair for one in scenarios for pair in one.propeller_pairs()),
        np.array([leader.eta for leader in leaders] + [boat.eta for boat in boats]),
        np.array([leader.nu for leader in leaders] + [boat.nu for boat in boats]),
        np.vstack([np.zeros((len(leaders), 2)), np.repeat(water, len(afloat[0]), axis=0)]),
        Weather(forces) if forces else None,
    )


def hulls_of(scenario: Scenario) -> list[HullParameters]:
    """Hull of every agent, the virtual leader first; the boats' include the mismatch."""
    reference, *boats = scenario.hulls()
    share = scenario.mismatch.share
    if share:
        rng = generator(scenario.seed, Stream.MISMATCH)
        boats = [hull.mismatched(boat, share, rng) for boat in boats]
    return [reference, *boats]


def _forces_of(
    scenarios: Sequence[Scenario], hulls: Sequence[Sequence[HullParameters]]
) -> list[Force]:
    """The weather's forces on the boats of each run; `hulls`: the hulls of each run's agents."""
    forces: list[Force] = []
    if any(one.white_noise.power for one in scenarios):
        forces.append(_white_noise_of(scenarios))
    if any(_blows(one) for one in scenarios):
        forces.append(_wind_of(scenarios))
    if any(one.waves.height_m for one in scenarios):
        bodies = [
            [_wave_body(*pair) for pair in zip(one.vessels()[1:], run, strict=True)]
            for one, run in zip(scenarios, hulls, strict=True)
        ]
        forces.append(Waves([_sea_of(one) for one in scenarios], bodies))
    return forces


def _white_noise_of(scenarios: Sequence[Scenario]) -> WhiteNoise:
    power = [one.white_noise.power for one in scenarios]
    rngs = [generator(one.seed, Stream.WHITE_NOISE) for one in scenarios]
    return WhiteNoise(power, scenarios[0].white_noise.sample_s, rngs, len(scenarios[0].boat))


def _blows(scenario: Scenario) -> bool:
    return bool(scenario.wind.gust_mps) or any(scenario.wind.mean_mps)


def _wind_of(scenarios: Sequence[Scenario]) -> Wind:
    gusts = Gusts(
        [one.wind.gust_mps for one in scenarios],
        [one.wind.gust_s for one in scenarios],
        [generator(one.seed, Stream.GUSTS) for one in scenarios],
    )
    # Without wind there is no air at all: still air would add drag.
    windages = [
        [vessel.windage if _blows(one) else _BECALMED for vessel in one.vessels()[1:]]
        for one in scenarios
    ]
    return Wind([one.wind.mean_mps for one in scenarios], gusts, windages)


def _sea_of(scenario: Scenario) -> Sea | None:
    if not scenario.waves.height_m:
        return None
    return Sea(**scenario.waves.model_dump(), rng=generator(scenario.seed, Stream.WAVES))


def _wave_body(vessel: Vessel, body: HullParameters) -> WaveBody:
    wetted = (vessel.length_m, vessel.draft_m, vessel.hull_y_m)
    return WaveBody(body.m11, body.m22, *wetted, vessel.drift_x_m, vessel.drift_y_m)
