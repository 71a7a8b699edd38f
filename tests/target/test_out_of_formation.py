# SPDX-License-Identifier: MIT
"""A boat that cannot keep its slot goes to COAST, then HOLD, with the reason."""

import pytest

from tests.target.hull import Afloat, Hull
from tests.target.operator_words import param_set
from tests.target.sea import named, texts
from tests.target.stations import FORMATION

FAST_N = 9.0  # of a leader that makes 2.6 m/s, more than LAW_U_MAX


def behind(away_s: float, parameters: dict[str, float] | None = None, **how: float) -> Afloat:
    """A boat 4 m behind its leader, which then sails faster than the boat may."""
    sea = Afloat(
        {"FORM_OFS_N": -4.0} | (parameters or {}),
        Hull([how.get("north", -4.0), how.get("east", 0.0), 0.0, 0.0, 0.0, 0.0]),
        leader=lambda t_s: (FAST_N if t_s > away_s else 1.5, 0.0),
    )
    sea.enter_formation()
    return sea


def told(sea: Afloat, name: str) -> list[float]:
    return [m.value for m in named(sea.ticks, "NAMED_VALUE_FLOAT") if m.name == name]


def test_leader_that_sails_away_is_followed_no_farther_than_the_limit() -> None:
    sea = behind(15.0)
    sea.run(14.0)
    assert sea.state == "FORMATION" and sea.snapshot()["in_slot"]
    assert told(sea, "IN_SLOT")[-1] == 1.0
    sea.run_until("COAST", 20.0)
    assert 4.9 < -sea.off_slot(-4.0)[0] < 7.0
    assert not sea.condition("on_station")
    said = texts(sea.ticks)
    assert any(t.startswith("boat left its slot: ") and "FS_SLOT_M is 5" in t for t in said), said
    assert "COAST: boat does not keep its slot or path" in said
    sea.run_until("HOLD", 5.1)
    assert not any(sea.commands)
    sea.run(1.0)
    assert sea.condition("on_station")  # nothing is judged that the law does not drive


def test_boat_closes_up_again_on_a_new_request() -> None:
    sea = behind(15.0)
    sea.run_until("COAST", 40.0)
    sea.run_until("HOLD", 6.0)
    sea.mode(FORMATION)
    sea.run(10.0)
    assert sea.state == "FORMATION" and -sea.off_slot(-4.0)[0] > 10.0
    assert told(sea, "IN_SLOT")[-1] == 0.0


def test_boat_that_comes_no_nearer_is_out_of_formation_after_half_a_minute() -> None:
    sea = behind(0.0, north=-30.0)
    sea.run(20.0)
    assert sea.state == "FORMATION"
    sea.run_until("COAST", 30.0)
    assert any(t.startswith("boat does not approach its slot: ") for t in texts(sea.ticks))


def test_boat_that_swings_to_and_fro_faster_than_it_may_turn_is_out_of_formation() -> None:
    sea = behind(1e9, {"LAW_R_MAX": 0.1})
    sea.own.answers_timesync = True  # what swings the boat is no latency
    sea.run(10.0)
    for k in range(20):
        sea.hull.push = (0.0, 4.0 if k % 2 else -4.0)
        sea.run(0.5)
        if sea.state != "FORMATION":
            break
    assert sea.state == "COAST"
    said = [t for t in texts(sea.ticks) if t.startswith("boat spins: ")]
    assert said and said[0].endswith(" rad/s, LAW_R_MAX is 0.1")


@pytest.mark.parametrize("name", ["FORM_OFS_N", "FORM_OFS_E"])
def test_boat_closes_up_again_to_another_slot(name: str) -> None:
    sea = behind(1e9, {"FORM_OFS_E": 8.0}, east=8.0)
    sea.run(30.0)
    assert sea.snapshot()["in_slot"]
    sea.say(param_set(name, {"FORM_OFS_N": -24.0, "FORM_OFS_E": -8.0}[name]))
    sea.run(3.0)
    assert sea.state == "FORMATION" and not sea.snapshot()["in_slot"]
    sea.run(60.0)
    assert sea.state == "FORMATION" and sea.snapshot()["in_slot"]


def test_fs_slot_m_0_disables_the_check() -> None:
    sea = behind(15.0, {"FS_SLOT_M": 0.0})
    sea.run(60.0)
    assert sea.state == "FORMATION" and -sea.off_slot(-4.0)[0] > 30.0
