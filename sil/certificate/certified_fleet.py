# SPDX-License-Identifier: MIT
"""The boats of a scenario behind one reference, with equal boats grouped together."""

from collections.abc import Mapping

import flotilla
import numpy as np

from sil.certificate.loop import Boat
from sil.certificate.references import Reference
from sil.certificate.slots import SlotMotion, slot_motion
from sil.plant.hull import HullParameters
from sil.scenario.agents import parameters_of
from sil.scenario.fleet_bodies import hulls_of
from sil.scenario.scenario import Scenario

_NOT_OF_THE_LOOP = ("MAV_SYSID", "FORM_LEADER")
_ALIKE = 1e-4  # rad, m/s, rad/s


def parameters(scenario: Scenario, overrides: dict[str, float]) -> list[dict[str, float]]:
    """All parameters of every boat, gains derived; ValueError if the firmware refuses one."""
    return [flotilla.derived(own) for own in parameters_of(scenario, overrides)]


def vessel_of(own: Mapping[str, float], speed_mps: float) -> HullParameters:
    """The vessel model of a firmware with these parameters, with D(u) at the given speed.

    PD+ keeps D(u) as the damping of the errors (`core/pd_plus.hpp`), as D in the paper.
    """
    d11 = own["VES_D11"] + own["VES_D11Q"] * speed_mps
    d33 = own["VES_D33"] + own["VES_D33U"] * speed_mps
    m11, m22, m33 = own["VES_M11"], own["VES_M22"], own["VES_M33"]
    return HullParameters(m11, m22, m33, d11, own["VES_D22"], d33)


def fleet(
    scenario: Scenario, reference: Reference, firmware: list[dict[str, float]]
) -> list[tuple[list[int], SlotMotion, Boat]]:
    """Numbers of boats with equal loops; slot and loop of the first of them.

    `firmware`: from `parameters`. Each boat's leader moves as its own slot requires.
    """
    motions = [reference.motion]
    hulls, pairs = hulls_of(scenario), scenario.propeller_pairs()
    current = scenario.water.current_mps
    groups: list[tuple[list[int], SlotMotion, Boat]] = []
    for agent, (boat, own) in enumerate(zip(scenario.boat, firmware, strict=True), start=1):
        leader = motions[boat.follows]
        offset_m = np.array([own["FORM_OFS_N"], own["FORM_OFS_E"]])
        slot = slot_motion(hulls[agent], np.array(current), leader, offset_m, _turns(own))
        motions.append(slot.motion)
        rates = (scenario.boat_unit(boat).rate_hz, scenario.rate_hz)
        setup = Boat(hulls[agent], pairs[agent - 1], own, current, *rates, leader, slot.motion)
        for agents, _, other in groups:
            if _same_loop(setup, other):
                agents.append(agent)
                break
        else:
            groups.append(([agent], slot, setup))
    return groups


def _turns(own: Mapping[str, float]) -> bool:
    return own.get("FORM_FRAME", 0.0) == 1.0


def _same_loop(a: Boat, b: Boat) -> bool:
    # a slot that does not turn is a mere shift, which affects no loop
    places = () if _turns(a.parameters) else ("FORM_OFS_N", "FORM_OFS_E")
    passed = {*_NOT_OF_THE_LOOP, *places}
    own, other = (
        ({k: v for k, v in x.parameters.items() if k not in passed}, x.hull, x.propellers)
        for x in (a, b)
    )
    if own != other or a.navigation_hz != b.navigation_hz:
        return False
    at_s = a.leader.times_s
    headings = np.abs(a.leader.eta(at_s)[:, 2] - b.leader.eta(at_s)[:, 2]).max()
    speeds = np.abs(a.leader.nu(at_s) - b.leader.nu(at_s)).max()
    return bool(headings < _ALIKE and speeds < _ALIKE)
