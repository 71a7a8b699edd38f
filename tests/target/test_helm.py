# SPDX-License-Identifier: MIT
"""flotilla.Helm: the boat's observer and law without messages, as certificates use it."""

from __future__ import annotations

import random
from typing import Any

import flotilla
import numpy as np
import pytest

from tests.target.course import Course
from tests.target.sea import PAPER, Sea
from tests.target.stations import FORMATION

SLOT = {"FORM_OFS_N": -1.0, "FORM_OFS_E": 2.0}
APPROACH = 19  # of the state: a switch
LAWS = pytest.mark.parametrize(
    "parameters",
    [PAPER | SLOT, SLOT, SLOT | {"FORM_FRAME": 1.0}],
    ids=["paper", "product", "turns"],
)


def sail(helm: Any, seed: int, steps: int, age_s: float = 0.0) -> list[dict[str, Any]]:
    """Step with a fix every fifth step and a different leader each time."""
    dice = random.Random(seed)
    told = []
    for k in range(steps):
        if k % 5 == 0:
            helm.fix(*(dice.uniform(-1, 1) for _ in range(6)), age_s=age_s, dt_s=0.05)
        leader = [dice.uniform(-1, 1) for _ in range(9)]
        told.append(helm.step(leader, 0.01))
    return told


def flat(told: list[dict[str, Any]]) -> list[float]:
    return [x for each in told for part in each.values() for x in part.values()]


@LAWS
@pytest.mark.parametrize("steps", [1, 5, 57])
def test_a_state_that_is_put_back_is_the_same_state(
    parameters: dict[str, float], steps: int
) -> None:
    helm, one, two = (flotilla.Helm(parameters) for _ in range(3))
    sail(helm, 1, steps)
    state = helm.state
    assert len(state) == 22 and len(set(state)) > 5
    one.state = state
    two.state = one.state
    assert one.state == two.state == state
    shown = sail(one, 2, 50)
    assert sail(two, 2, 50) == shown and two.state == one.state
    # The position is stored in two parts; the state has their sum. Earlier inputs are not in
    # it, but current fixes do not need them.
    assert flat(sail(helm, 2, 50)) == pytest.approx(flat(shown), rel=1e-12, abs=1e-12)


@LAWS
def test_the_same_steps_from_the_same_state_end_in_the_same_state(
    parameters: dict[str, float],
) -> None:
    helm = flotilla.Helm(parameters)
    sail(helm, 3, 20)
    before = helm.state
    helm.state = before
    shown = sail(helm, 4, 30, age_s=0.012)
    after = helm.state
    sail(helm, 5, 7)  # elsewhere, with a fix that is still pending
    helm.fix(9.0, 9.0, 1.0, 1.0, 1.0, 1.0)
    helm.state = before
    assert sail(helm, 4, 30, age_s=0.012) == shown and helm.state == after
    helm.state = before
    assert sail(helm, 6, 30, age_s=0.012) != shown


@LAWS
def test_several_step_together_as_each_does_alone(parameters: dict[str, float]) -> None:
    dice = np.random.default_rng(7)
    alone, together = [flotilla.Helm(parameters) for _ in range(3)], flotilla.Helms(parameters, 3)
    eta, nu, rows, thrusts = (dice.uniform(-1, 1, (3, n)) for n in (3, 3, 22, 2))
    for k in range(60):
        if k % 5 == 0:
            eta, nu = dice.uniform(-1, 1, (2, 3, 3))
            together.fix(eta, nu, 0.012, 0.05)
        leader = dice.uniform(-1, 1, 9).tolist()
        most = together.step(leader, 0.01, thrusts)
        together.state(rows)
        lacks = []
        for i, helm in enumerate(alone):
            if k % 5 == 0:
                helm.fix(*eta[i], *nu[i], 0.012, 0.05)
            told = helm.step(leader, 0.01)
            asked, given = told["wrench_asked"], told["wrench_given"]
            lacks.append(sum(abs(asked[axis] - given[axis]) for axis in asked))
            assert thrusts[i].tolist() == list(told["thrust_N"].values())
            assert rows[i].tolist() == helm.state
        assert most == max(lacks)
        if k == 30:
            rows = rows[::-1].copy()
            together.set_state(rows)
            for helm, row in zip(alone, rows, strict=True):
                helm.state = row.tolist()
    assert len(set(thrusts.ravel().tolist())) == 6


def test_a_number_of_rows_other_than_that_of_the_helms_is_refused() -> None:
    with pytest.raises(ValueError, match="as many rows"):
        flotilla.Helms({}, 3).set_state(np.zeros((2, 22)))


def test_each_number_of_the_state_affects_the_output() -> None:
    parameters = SLOT | {"LAW_U_MAX": 0.0, "LAW_R_MAX": 0.0}
    helm = flotilla.Helm(parameters)
    sail(helm, 1, 22)
    state = helm.state
    helm.state = state
    shown = sail(helm, 2, 3)
    for k in set(range(len(state))) - {APPROACH}:
        helm.state = [x + 0.01 * (i == k) for i, x in enumerate(state)]
        assert sail(helm, 2, 3) != shown, k


def test_a_helm_remembers_whether_it_approaches_and_which_end_first() -> None:
    resting = [0.0] * 9
    wanted = {}
    for way in (0.0, 1.0, -1.0):
        helm = flotilla.Helm()
        helm.fix(0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
        helm.step(resting, 0.01)
        assert helm.state[APPROACH] == 0.0  # 1 m abeam is near enough
        helm.state = [way if k == APPROACH else x for k, x in enumerate(helm.state)]
        wanted[way] = helm.step(resting, 0.01)["virtual_velocity"]["r_radps"]
        assert helm.state[APPROACH] == way
    assert wanted[0.0] == pytest.approx(0.0, abs=1e-6)
    assert wanted[1.0] < -0.19 and wanted[-1.0] > 0.19  # a quarter of LAW_R_MAX in the first tick


class Twin:
    """A helm that gets at each tick the values of the sea's messages."""

    def __init__(self, sea: Sea, parameters: dict[str, float]) -> None:
        self.sea, self.helm = sea, flotilla.Helm(parameters)
        self.dt_s = 0.0  # the first fix has none before it

    def step(self, drive: bool = False) -> dict[str, Any]:
        now_us, own = self.sea.ticks[-1].now_us, self.sea.own
        if own.next_us - own.period_us == now_us:
            self.helm.fix(*vars(own.truth(now_us)).values(), dt_s=self.dt_s)
            self.dt_s = own.period_us * 1e-6
        leader = [*vars(self.sea.leader.truth(now_us)).values(), 0.0, 0.0, 0.0]
        return dict(self.helm.step(leader, 0.01, drive))


def assert_alike(sea: Sea, told: dict[str, Any], *keys: str) -> None:
    seen = sea.snapshot()
    for key in keys:
        assert seen[key] == pytest.approx(told[key], rel=1e-5, abs=1e-5), key


@LAWS
@pytest.mark.parametrize("own_period_us", [10_000, 50_000])
def test_a_helm_computes_the_same_as_a_boat_with_the_same_input(
    parameters: dict[str, float], own_period_us: int
) -> None:
    """From arming to the first driven tick, to the precision of the messages."""
    own, leader = Course(1.0, 2.0, 0.3, 0.4, -0.05, 0.2), Course(5.0, 5.0, 0.5, 0.6, 0.02, -0.1)
    without = {"THR_SLEW": 0.0, "LAW_REF": 0.0}  # the helm has no reference
    sea = Sea(parameters | without, own=own, leader=leader, scalar="double")
    sea.own.period_us, sea.leader.period_us = own_period_us, sea.period_us
    sea.run(0.51)  # the last of these ticks has a fix
    twin = Twin(sea, parameters)
    twin.step()
    sea.arm()
    twin.step()
    for _ in range(30):
        sea.step()
        assert_alike(sea, twin.step(), "error", "unknown", "current_mps")
    assert sea.state == "HOLD" and not any(sea.commands)
    sea.mode(FORMATION)
    told = twin.step(drive=True)
    assert_alike(sea, told, "error", "virtual_velocity", "wrench_asked", "unknown", "current_mps")
    assert any(sea.commands)
    assert any(told["unknown"].values()) == (parameters.get("LAW_OBS_BW") != 0.0)
