# SPDX-License-Identifier: MIT
"""The settings at which the law's table is sailed."""

import flotilla

from sil.results.claims import CLAIMS, DEFAULTS
from sil.scenario import scenario

# a row says so where it is about the thrust, the rate or the unit
SHARED = ("SR_STATE", "THR_SLEW", "THR_FWD_MAX", "THR_REV_MAX")


def test_product_is_sailed_with_the_firmwares_defaults_and_their_propellers() -> None:
    defaults = flotilla.Boat({}, links=1).parameters()
    sailed = scenario.load("diamond", DEFAULTS, "product")
    for name in SHARED:
        assert sailed.parameters[name] == defaults[name], name
    assert sailed.propellers.forward_max_N == defaults["THR_FWD_MAX"]
    assert sailed.propellers.reverse_max_N == defaults["THR_REV_MAX"]
    assert sailed.navigation.rate_hz == 10.0


def test_a_row_differs_from_the_defaults_only_where_it_is_meant_to() -> None:
    defaults = flotilla.Boat({}, links=1).parameters()
    found = {}
    for name, claim in CLAIMS.items():
        sailed = scenario.load(name, claim.settings("product"), "product")
        own = {key for key in SHARED if sailed.parameters.get(key, defaults[key]) != defaults[key]}
        unit = {f"{sailed.navigation.rate_hz:g} Hz"} - {"10 Hz"}
        if own | unit:
            found[name] = own | unit
    thrust = {"THR_FWD_MAX", "THR_REV_MAX"}
    lines = {name: {"20 Hz"} for name in ("line10", "line20", "line20_relay", "star20")}
    assert found == {
        "weak_link": {"SR_STATE"},
        "noisy": {"20 Hz"},
        "late_unit": {"20 Hz"},
        "limits": thrust,
        "resting_leader": {"20 Hz"},
        "sea": thrust,
        "tail_wind": {"20 Hz", *thrust},
        **lines,
    }


def test_papers_law_sails_every_scenario_as_its_file_is() -> None:
    assert {claim.settings("paper") for claim in CLAIMS.values()} == {()}
