# SPDX-License-Identifier: MIT
"""The bodies of a scenario and what moves them: its plant, from its keys and its seed."""

from collections.abc import Sequence

import numpy as np

from sil.plant import hull
from sil.plant.fleet import Fleet
from sil.plant.hull import HullParameters
from sil.plant.waves import WaveBody, Waves
from sil.plant.weather import Force, Weather, WhiteNoise
from sil.plant.wind import Gusts, Wind
from sil.scenario import Scenario, Vessel
from sil.streams import Stream, generator


def fleet_of(scenario: Scenario) -> Fleet:
    """The bodies of a scenario's agents, at its beginning.

    The virtual leader is a reference: nothing but its input acts on it, and its hull is nominal.
    """
    eta = [scenario.leader.eta, *(boat.eta for boat in scenario.boat)]
    nu = [scenario.leader.nu, *(boat.nu for boat in scenario.boat)]
    current = np.tile(scenario.water.current_mps, (len(eta), 1))
    current[0] = 0.0
    hulls = hulls_of(scenario)
    forces = _forces_of(scenario, hulls[1:])
    weather = Weather(forces) if forces else None
    return Fleet(hulls, scenario.propeller_pairs(), eta, nu, current, weather)


def hulls_of(scenario: Scenario) -> list[HullParameters]:
    """Hull of every agent, the virtual leader first; the boats' with the scenario's mismatch."""
    reference, *boats = scenario.hulls()
    share = scenario.mismatch.share
    if share:
        rng = generator(scenario.seed, Stream.MISMATCH)
        boats = [hull.mismatched(boat, share, rng) for boat in boats]
    return [reference, *boats]


def _forces_of(scenario: Scenario, hulls: Sequence[HullParameters]) -> list[Force]:
    """What pushes the boats of a scenario, whose hulls are `hulls`."""
    boats = scenario.vessels()[1:]
    forces: list[Force] = []
    noise, wind, waves = scenario.white_noise, scenario.wind, scenario.waves
    if noise.power:
        rng = generator(scenario.seed, Stream.WHITE_NOISE)
        forces.append(WhiteNoise(noise.power, noise.sample_s, rng))
    if wind.gust_mps or any(wind.mean_mps):
        gusts = Gusts(wind.gust_mps, wind.gust_s, generator(scenario.seed, Stream.GUSTS))
        forces.append(Wind(wind.mean_mps, gusts, [boat.windage for boat in boats]))
    if waves.height_m:
        bodies = [_wave_body(boat, body) for boat, body in zip(boats, hulls, strict=True)]
        rng = generator(scenario.seed, Stream.WAVES)
        forces.append(Waves(**waves.model_dump(), bodies=bodies, rng=rng))
    return forces


def _wave_body(vessel: Vessel, body: HullParameters) -> WaveBody:
    wetted = (vessel.length_m, vessel.draft_m, vessel.hull_y_m)
    return WaveBody(body.m11, body.m22, *wetted, vessel.drift_x_m, vessel.drift_y_m)
