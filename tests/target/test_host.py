# SPDX-License-Identifier: MIT
"""Information from the boat's host: the bus, saved parameters, the loop, a radio's rate."""

import pytest

from tests.target.sea import Sea, acks, at_sea, messages, named, texts

SAVE = 245
REFUSED = 1


@pytest.mark.parametrize(
    ("report", "condition", "said"),
    [
        ({"bus_up": False}, "bus_up", ["PreArm: CAN bus is down"]),
        (
            {"parameters_saved": False},
            "parameters_saved",
            [
                "PreArm: parameters or fence are not saved",
                "parameters are default or old: check and save them",
            ],
        ),
    ],
)
def test_a_boat_does_not_arm_while_its_host_reports_a_problem(
    sea: Sea, report: dict[str, bool], condition: str, said: list[str]
) -> None:
    sea.settle()
    sea.boat.on_host(**report)
    tick = sea.arm()
    assert acks(tick) == [(400, REFUSED)]
    assert texts([tick]) == said
    assert not sea.condition(condition)
    sea.boat.on_host()
    sea.enter_hold()


def test_a_bus_that_fails_under_way_is_a_fault() -> None:
    sea = at_sea()
    sea.boat.on_host(bus_up=False)
    tick = sea.step()
    assert sea.state == "FAULT" and tick.commands == (0, 0) and tick.arming == [0]
    assert texts([tick]) == ["FAULT: CAN bus is down"]


def test_parameters_that_were_never_saved_do_not_stop_a_boat_under_way() -> None:
    sea = at_sea()
    sea.boat.on_host(parameters_saved=False)
    sea.run(1.0)
    assert sea.state == "FORMATION"


def test_a_request_to_save_is_acknowledged_and_passed_to_the_host_once(sea: Sea) -> None:
    sea.settle()
    assert sea.boat.take_save_request() == "none"
    assert acks(sea.order(SAVE, 1.0)) == [(SAVE, 0)]
    assert sea.boat.take_save_request() == "confirmed"
    assert sea.boat.take_save_request() == "none"
    assert acks(sea.order(SAVE, 2.0)) == [(SAVE, 2)]
    assert sea.boat.take_save_request() == "none"


def test_overruns_and_ages_are_slow_telemetry(sea: Sea) -> None:
    sea.boat.on_host(overruns=7)
    sea.run(5.0)
    sent = named(sea.ticks, "NAMED_VALUE_FLOAT")
    values = {m.name: m.value for m in sent}
    assert values["OVERRUNS"] == 7.0
    assert 0.0 <= values["NAV_AGE"] < 0.1
    assert 0.0 <= values["LEAD_AGE"] < 0.2
    for name in ("OVERRUNS", "NAV_AGE", "LEAD_AGE"):
        assert [m.name for m in sent].count(name) == pytest.approx(5, abs=1)


def test_a_slow_radio_keeps_its_rate_and_carries_heartbeats_states_and_acks() -> None:
    sea = Sea({"SR_STATE": 50}, links=2)
    sea.boat.limit_link(1, 400)
    sea.enter_formation()
    sea.ticks.clear()
    sea.run(30.0)
    said = [sum(len(d) for t in sea.ticks for at, d in t.mavlink if at == link) for link in (0, 1)]
    assert said[0] > 30 * 2000
    assert said[1] == pytest.approx(30 * 400, rel=0.15)
    kinds = [m.get_type() for m in messages(sea.ticks, link=1)]
    assert kinds.count("HEARTBEAT") == 30
    assert kinds.count("LOCAL_POSITION_NED") > 50
    assert acks(sea.order(400, 0.0, link=1), link=1) == [(400, 0)]


def test_a_failing_disk_is_reported_to_the_operator_once(sea: Sea) -> None:
    sea.settle()
    sea.ticks.clear()
    for failed in (False, True, True, True, False, True):
        sea.boat.on_host(save_failed=failed)
        sea.run(1.0)
    told = [m.text for m in messages(sea.ticks) if m.get_type() == "STATUSTEXT"]
    assert len([text for text in told if text.startswith("parameters could not be saved")]) == 2
