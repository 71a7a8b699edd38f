# SPDX-License-Identifier: MIT
"""Boats of scenarios, set up as for the analysis of their loops."""

from collections.abc import Mapping, Sequence

from sil.certificate.certified_fleet import fleet, parameters
from sil.certificate.loop import Boat
from sil.certificate.references import Reference, references
from sil.scenario import scenario
from sil.scenario.law import Law

SINE = "leader.input.1.yaw_sine_Nm=0.0"
AT_REST = (SINE, "leader.input.1.surge_N=0.0")
TURN = (SINE, "leader.input.1.yaw_Nm=0.15")


def boat(
    *overrides: str,
    law: Law = "paper",
    changed: Mapping[str, float] | None = None,
    agent: int = 1,
) -> Boat:
    """A boat of `diamond` behind its first reference."""
    return behind(overrides, law, changed or {}, agent)[1]


def behind(
    overrides: Sequence[str], law: Law, changed: Mapping[str, float], agent: int
) -> tuple[Reference, Boat]:
    """The reference as well."""
    chosen = scenario.load("diamond", overrides, law)
    reference = references(chosen)[0]
    groups = fleet(chosen, reference, parameters(chosen, dict(changed)))
    return reference, next(setup for boats, _, setup in groups if agent in boats)
