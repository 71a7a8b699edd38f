# SPDX-License-Identifier: MIT
"""The agents of a scenario: system ids, firmware parameters, clocks, navigation units."""

from collections.abc import Mapping, Sequence

import numpy as np

from sil.plant.hull import Array
from sil.scenario.scenario import Scenario
from sil.scenario.streams import Stream, generator
from sil.scenario.wiring import VIRTUAL_LEADER_SYSTEM
from sil.wire.clock import Clock
from sil.wire.navigation_unit import Settings

_SYSTEMS = 250


def systems_of(scenario: Scenario) -> list[int]:
    """System id of every agent, the virtual leader first: boat i has i; after 250, ids repeat.

    A boat's id differs from the ids of its leader and of its leader's leader. It also differs from
    those of its fellow followers, unless they outnumber the ids.
    """
    systems = [VIRTUAL_LEADER_SYSTEM]
    # The ids that each agent hears: its own, its leader's, then its followers'.
    heard = [[VIRTUAL_LEADER_SYSTEM]]
    for agent in range(1, len(scenario.boat) + 1):
        leader = _leader_of(scenario, agent)
        near = heard[leader]
        taken = near if len(near) < _SYSTEMS else near[:2]
        system = (agent - 1) % _SYSTEMS + 1
        while system in taken:
            system = system % _SYSTEMS + 1
        systems.append(system)
        near.append(system)
        heard.append([system, systems[leader]])
    return systems


def _leader_of(scenario: Scenario, agent: int) -> int:
    """The agent whose system id is FORM_LEADER; for a boat that leads, 0, which no boat has."""
    leader = scenario.heard_by(agent)
    return 0 if leader == agent else leader


def parameters_of(scenario: Scenario, overrides: dict[str, float]) -> list[dict[str, float]]:
    """Firmware parameters of every boat: its slot's, then the scenario's, then `overrides`."""
    systems = systems_of(scenario)
    return [
        {
            "MAV_SYSID": systems[agent],
            "FORM_LEADER": systems[_leader_of(scenario, agent)],
            "FORM_OFS_N": boat.offset_m[0],
            "FORM_OFS_E": boat.offset_m[1],
            "CTL_RATE": scenario.rate_hz,
            **scenario.firmware_parameters(boat),
            **overrides,
        }
        for agent, boat in enumerate(scenario.boat, start=1)
    ]


def slots_of(parameters: Sequence[Mapping[str, float]]) -> Array:
    """FORM_OFS_N, FORM_OFS_E and FORM_FRAME (N, 3) from the boats' firmware parameters."""
    names = ("FORM_OFS_N", "FORM_OFS_E", "FORM_FRAME")
    return np.array([[own.get(name, 0.0) for name in names] for own in parameters])


def clocks_of(scenario: Scenario) -> list[Clock]:
    """A clock for every agent, with the offset and drift that the scenario's seed draws."""
    rng = generator(scenario.seed, Stream.CLOCKS)
    clocks = scenario.clocks
    return [
        Clock(
            round(1e6 * clocks.offset_s * rng.random()), clocks.drift_ppm * rng.uniform(-1.0, 1.0)
        )
        for _ in range(len(scenario.boat) + 1)
    ]


def units_of(scenario: Scenario) -> list[Settings]:
    """Settings of every agent's navigation unit, the virtual leader's first."""
    return [scenario.leader_unit(), *(scenario.boat_unit(boat) for boat in scenario.boat)]
