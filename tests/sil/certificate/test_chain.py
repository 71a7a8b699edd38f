# SPDX-License-Identifier: MIT
"""Chains: the certified depth is the depth to which they hold in simulation."""

from collections.abc import Mapping
from functools import cache
from itertools import product
from typing import Any

import flotilla
import pytest

from sil.certificate import agreement, chain, probe
from sil.certificate.certified_fleet import parameters
from sil.certificate.references import references
from sil.lockstep.start import RunError
from sil.scenario import scenario
from sil.scenario.law import Law
from sil.scenario.scenario import Scenario
from tests.each_push import few


@pytest.mark.parametrize(
    ("law", "delay_s"),
    few(product(("product", "paper"), agreement.DELAYS_S), [("product", 0.2)]),
)
def test_a_chain_breaks_in_simulation_where_it_stops_being_certified(
    law: Law, delay_s: float
) -> None:
    found = agreement.compare("line10", law, {"LAW_REF": 0.0}, delay_s)
    assert found.agree, found
    assert 0 < found.certified < 10, found


@cache
def followed(delay_s: float) -> chain.Chain:
    """A chain of boats: each follows the one before it."""
    late = scenario.load("line10", [f"link.delay_s={delay_s}"])
    return chain.chain(late, references(late)[0], {"LAW_REF": 0.0})


@pytest.mark.parametrize(
    ("delay_s", "most"), few([(0.0, 1.56), (0.1, 2.1), (0.2, 2.8)], [(0.2, 2.8)])
)
def test_each_hop_amplifies_more_the_later_the_radio_is(delay_s: float, most: float) -> None:
    assert max(followed(delay_s).yaw.hop) == pytest.approx(most, abs=0.15)  # measured in chains


def test_a_slow_turn_passes_a_hop_without_amplification() -> None:
    found = followed(0.2)
    assert found.yaw.hop[0] == pytest.approx(1.0, abs=0.05)
    assert found.surge.hop[0] == pytest.approx(1.0, abs=0.05)


def lines(name: str, *overrides: str) -> list[list[int]]:
    chosen = scenario.load(name, overrides)
    return chain.lines(chosen, parameters(chosen, {}))


def test_lines_of_equal_boats_are_examined_once_and_others_each() -> None:
    branches = [f"boat.{boat}.follows={boat - 2}" for boat in range(3, 11)]  # two lines of five
    equal = ["boat.2.follows=0", *branches]
    assert lines("line10", *equal) == [[1, 3, 5, 7, 9]]
    other = [*equal, "boat.10.parameters={LAW_KX=0.3}"]
    assert lines("line10", *other) == [[1, 3, 5, 7, 9], [2, 4, 6, 8, 10]]
    shorter = [*equal, "boat.9.follows=0", "boat.10.parameters={LAW_REF=0}"]
    assert lines("line10", *shorter) == [[2, 4, 6, 8, 10], [1, 3, 5, 7]]
    assert lines("star20") == [[1, 2]]


def test_limits_are_raised_by_the_motion_of_the_root_alone() -> None:
    own = {"LAW_R_MAX": 0.0, "LAW_U_MAX": 1.2}
    slow = chain.limits_of([own], flotilla.derived(), (0.1, 0.5))
    assert (slow.yaw_rate, slow.speed) == pytest.approx((0.76, 1.2))
    fast = chain.limits_of([own], flotilla.derived(), (1.0, 2.0))
    assert (fast.yaw_rate, fast.speed) == pytest.approx((1.2, 2.4))
    assert slow.off_slot_m == fast.off_slot_m == chain.OFF_SLOT_M


@pytest.mark.parametrize(("state", "named"), [("HOLD", True), ("COAST", False)])
def test_boat_that_leaves_formation_in_a_probe_is_named(state: str, named: bool) -> None:
    states: list[Mapping[str, float]] = [{"FORMATION": 9.0}] * 2
    states += [{"FORMATION": 6.0, state: 3.0}]
    if not named:
        return probe.stay(states, [4, 7])
    with pytest.raises(RunError, match=f"boat 7, at depth 3, leaves FORMATION: {state}"):
        probe.stay(states, [4, 7])
    return None


def relaying(loss: float) -> Scenario:
    return scenario.load("line10", ["link.everyone=false", f"link.loss={loss}"])


@pytest.mark.nightly
def test_boats_that_relay_without_losses_are_certified_to_that_depth_too() -> None:
    relayed = relaying(0.0)
    assert chain.chain(relayed, references(relayed)[0], {}, most=3).certified == 3


def test_depth_is_not_beyond_where_boats_break_in_runs_with_lost_messages(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(probe, "LOSSY_RUNS", 1)
    relayed = relaying(0.3)
    assert chain.chain(relayed, references(relayed)[0], {}, most=3).certified == 3
    real = probe.probe

    def jumping(*given: Any) -> probe.Probe:
        sailed = real(*given)
        ((nu, _),) = sailed.lossy
        nu[100, 3, probe.YAW] = 1.13  # boat 3, once
        return sailed

    monkeypatch.setattr(probe, "probe", jumping)
    assert chain.chain(relayed, references(relayed)[0], {}, most=3).certified == 2
