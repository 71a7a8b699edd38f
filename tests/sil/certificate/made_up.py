# SPDX-License-Identifier: MIT
"""References, boats and certificates of scenarios, as the analysis of their loops uses them."""

from collections.abc import Mapping, Sequence

import pytest

from sil.certificate import chain, margins, search
from sil.certificate.certificate import Certificate, certify
from sil.certificate.certified_fleet import fleet, parameters
from sil.certificate.loop import Boat
from sil.certificate.references import Reference, references
from sil.plant.hull import HullParameters
from sil.scenario import scenario
from sil.scenario.law import Law

#: The paper's vessel.
VESSEL = HullParameters(m11=1.012, m22=1.982, m33=0.354, d11=3.436, d22=18.99, d33=0.864)
SINE = "leader.input.1.yaw_sine_Nm=0.0"
AT_REST = (SINE, "leader.input.1.surge_N=0.0")
TURN = (SINE, "leader.input.1.yaw_Nm=0.15")


def reference(*overrides: str) -> Reference:
    """The only reference of `diamond`."""
    (found,) = references(scenario.load("diamond", overrides))
    return found


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


def quick_certificate(name: str, overrides: Sequence[str], law: Law | None) -> Certificate:
    """The certificate of a scenario without search, margins and chain."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(search, "SEARCH_CYCLES", 0)
        patch.setattr(margins, "STEPS", 0)
        patch.setattr(chain, "MOST_DEPTH", 0)
        return certify(scenario.load(name, overrides, law), {}, lambda what, share: None)
