# SPDX-License-Identifier: MIT
"""GUIDED, LOITER and RTL: a boat sails to a target, waits, and comes home."""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.hull import Afloat, Hull
from tests.target.plans import (
    ITEM_ACCEPTED,
    LOITER_UNLIMITED,
    RALLY,
    REFUSED,
    RETURN,
    SPEED,
    UNSUPPORTED_FRAME,
    UNSUPPORTED_ITEM,
    Item,
    Planner,
    at,
    plan_of,
    rally,
)
from tests.target.sea import Sea, Tick, acks, texts
from tests.target.stations import (
    ACCEPTED,
    ARM,
    AUTO,
    BOAT,
    DENIED,
    FORMATION,
    GCS,
    GUIDED,
    HOLD,
    LOITER,
    REPOSITION,
    RTL,
    SET_MODE,
    STANDARD_MODE,
    TEMPORARILY_REJECTED,
    Station,
    command_long,
)
from tests.target.test_auto import CORNER, at_sea, place, sailing

INT_ONLY, WRONG_FRAME = 8, 9
CHANGE_MODE = 1.0


def reposition(
    sea: Afloat,
    to: Item,
    *,
    speed_mps: float = math.nan,
    flags: float = CHANGE_MODE,
    frame: int = 6,
) -> Tick:
    """MAV_CMD_DO_REPOSITION by COMMAND_INT, as clients send it."""
    sea.say(
        mavlink.MAVLink_command_int_message(
            BOAT, 1, frame, REPOSITION, 0, 0, speed_mps, flags, 0, math.nan, to.x, to.y, math.nan
        )
    )
    return sea.step()


def guided(north_m: float = 10.0, east_m: float = 0.0, speed_mps: float = math.nan) -> Afloat:
    sea = at_sea([])
    assert acks(reposition(sea, at(north_m, east_m), speed_mps=speed_mps)) == [
        (REPOSITION, ACCEPTED)
    ]
    sea.step()
    assert sea.state == "GUIDED"
    return sea


class Failing(Afloat):
    """A boat whose propellers can fail: the shares that they obey."""

    shares = (1, 1)

    def obeyed(self, commands: tuple[int, ...]) -> tuple[int, ...]:
        return tuple(share * each for share, each in zip(self.shares, commands, strict=True))


@pytest.mark.parametrize("every_s", [0.1, 0.5])
@pytest.mark.parametrize(("shares", "push_N"), [((0, 0), 0.0), ((0, 1), 0.0), ((1, 1), -45.0)])
def test_places_that_come_often_do_not_switch_off_the_watch_on_the_boats_response(
    every_s: float, shares: tuple[int, int], push_N: float
) -> None:
    sea = at_sea([], kind=Failing)
    assert isinstance(sea, Failing)
    sea.mode(GUIDED)
    sea.run(10.0)
    for k in range(round(40.0 / every_s)):
        if k * every_s >= 20.0:
            sea.shares, sea.hull.push = shares, (push_N, 0.0)
        reposition(sea, at(40 + 0.5 * (k % 2), 0), flags=0.0)
        sea.run(every_s)
        if sea.state != "GUIDED":
            break
    assert 20.0 <= k * every_s < 30.0 and sea.state == "HOLD" and not any(sea.commands)
    assert "HOLD: boat does not respond to thrust" in " ".join(texts(sea.ticks))


def test_a_boat_follows_a_place_that_moves_and_stops_with_it() -> None:
    sea = at_sea([])
    sea.mode(GUIDED)
    for k in range(300):
        reposition(sea, at(5 + 0.03 * k, 0), flags=0.0)
        sea.run(0.1)
    assert sea.state == "GUIDED" and sea.hull.seen.u == pytest.approx(0.3, abs=0.2)
    sea.run(30.0)
    assert place(sea) == pytest.approx((5 + 0.03 * 299, 0), abs=0.05)


def test_a_boat_sails_to_its_target_and_waits_there() -> None:
    sea = guided(10.0, 5.0)
    sea.run(60.0)
    assert place(sea) == pytest.approx((10, 5), abs=0.05) and sea.state == "GUIDED"
    assert math.hypot(*sea.hull.q[3:5]) < 0.01
    assert sea.snapshot()["in_slot"]


def test_a_new_target_takes_the_place_of_the_old_one_under_way() -> None:
    sea = guided(20.0)
    sea.run(10.0)
    assert 1.0 < place(sea)[0] < 8.0
    assert acks(reposition(sea, at(5, 10), flags=0.0)) == [(REPOSITION, ACCEPTED)]
    sea.run(60.0)
    assert place(sea) == pytest.approx((5, 10), abs=0.05) and sea.state == "GUIDED"


def test_the_speed_of_a_target_is_kept() -> None:
    sea = guided(20.0, speed_mps=0.3)
    sea.run(20.0)
    assert sea.hull.seen.u == pytest.approx(0.3, abs=0.01)


def go_here(
    sea: Afloat, to: Item, current: int = 2, frame: int = 6, sender: Station | None = None
) -> Tick:
    """A MISSION_ITEM_INT of ArduPilot's clients that is a target and not an item of a plan."""
    item = to._replace(frame=frame).message(0)
    item.current = current
    sea.say(item, sender=sender)
    return sea.step()


def mission_acks(tick: Tick) -> list[int]:
    assert not acks(tick)
    return [m.type for m in tick.named("MISSION_ACK")]


def test_go_here_of_ardupilots_clients_is_a_target_in_guided() -> None:
    sea = guided(20.0)
    assert mission_acks(go_here(sea, at(5, 10))) == [ITEM_ACCEPTED]
    sea.run(60.0)
    assert place(sea) == pytest.approx((5, 10), abs=0.05) and sea.state == "GUIDED"
    assert plan_of(sea) == []


def test_go_here_changes_no_mode_and_a_change_of_altitude_nothing() -> None:
    sea = at_sea([])
    tick = go_here(sea, at(5, 0))
    assert mission_acks(tick) == [REFUSED]
    assert "Refused: target needs GUIDED" in texts([tick, sea.step()])
    sea.mode(GUIDED)
    for current in (3, 4, 255):
        assert mission_acks(go_here(sea, at(5, 0), current)) == [UNSUPPORTED_ITEM]
    for command in (LOITER_UNLIMITED, SPEED):
        assert mission_acks(go_here(sea, at(5, 0)._replace(command=command))) == [UNSUPPORTED_ITEM]
    assert mission_acks(go_here(sea, at(3000, 0))) == [REFUSED]
    assert mission_acks(go_here(sea, at(5, 0), frame=1)) == [UNSUPPORTED_FRAME]
    sea.run(20.0)
    assert place(sea) == pytest.approx((0, 0), abs=0.05)


def test_go_here_of_a_station_that_may_not_command_is_refused() -> None:
    sea = at_sea([], {"MAV_GCS_SYSID": GCS})
    sea.mode(GUIDED)
    assert mission_acks(go_here(sea, at(5, 0), sender=Station(9, 190))) == [REFUSED]
    assert mission_acks(go_here(sea, at(5, 0))) == [ITEM_ACCEPTED]


@pytest.mark.parametrize("speed_mps", [0.01, 1.6, 6.0, -2.0, math.inf])
def test_a_speed_that_the_boat_must_not_have_is_denied(speed_mps: float) -> None:
    sea = at_sea([])
    assert acks(reposition(sea, at(5, 0), speed_mps=speed_mps)) == [(REPOSITION, DENIED)]
    sea.run(1.0)
    assert sea.state == "HOLD" and not any(sea.commands)


def test_a_target_without_the_change_of_mode_is_denied_outside_guided() -> None:
    sea = at_sea([])
    tick = reposition(sea, at(5, 0), flags=0.0)
    assert acks(tick) == [(REPOSITION, DENIED)]
    assert "Refused: target needs GUIDED" in texts([tick, sea.step()])
    sea.mode(GUIDED)
    sea.run(20.0)
    assert place(sea) == pytest.approx((0, 0), abs=0.05)  # the refused target is forgotten


@pytest.mark.parametrize("far_m", [2899.0, 2901.0])
def test_a_target_out_of_reach_is_denied_before_the_mode_changes(far_m: float) -> None:
    sea = at_sea([])
    near = far_m < 2900
    tick = reposition(sea, at(far_m, 0))
    assert acks(tick) == [(REPOSITION, ACCEPTED if near else DENIED)]
    sea.run(3.0)
    assert sea.state == ("GUIDED" if near else "HOLD") and any(sea.commands) == near


@pytest.mark.parametrize("frame", [1, 7, 8, 9, 12, 20])
def test_a_target_in_a_local_frame_is_refused(frame: int) -> None:
    sea = at_sea([])
    assert acks(reposition(sea, at(5, 0), frame=frame)) == [(REPOSITION, WRONG_FRAME)]
    assert sea.state == "HOLD"


def test_a_target_in_degrees_as_floats_is_refused() -> None:
    sea = at_sea([])
    assert acks(sea.order(REPOSITION, -1.0, 1.0, 0.0, 0.0, 47.4, 8.5, 0.0)) == [
        (REPOSITION, INT_ONLY)
    ]
    assert sea.state == "HOLD"


def test_a_disarmed_boat_goes_nowhere() -> None:
    sea = at_sea([])
    sea.disarm()
    assert acks(reposition(sea, at(5, 0))) == [(REPOSITION, TEMPORARILY_REJECTED)]
    sea.arm()
    sea.run(1.0)
    assert sea.state == "HOLD"
    sea.mode(GUIDED)
    sea.run(20.0)
    assert place(sea) == pytest.approx((0, 0), abs=0.05)


def test_a_hold_after_the_target_in_the_same_tick_forgets_it() -> None:
    sea = at_sea([])
    target = at(5, 0)
    sea.say(
        mavlink.MAVLink_command_int_message(
            BOAT, 1, 6, REPOSITION, 0, 0, -1.0, 1.0, 0, 0, target.x, target.y, 0
        ),
        mavlink.MAVLink_set_mode_message(BOAT, 1, HOLD),
    )
    sea.step()
    assert sea.state == "HOLD"
    sea.mode(GUIDED)
    sea.run(20.0)
    assert place(sea) == pytest.approx((0, 0), abs=0.05)


def test_guided_without_a_target_stops_the_boat_and_waits() -> None:
    sea = sailing([at(40, 0)])
    sea.run(15.0)
    begins = place(sea)[0]
    assert acks(sea.mode(GUIDED)) == [(SET_MODE, ACCEPTED)]
    sea.run(30.0)
    stopped = place(sea)
    assert 0.2 < stopped[0] - begins < 4.0
    sea.run(10.0)
    assert place(sea) == pytest.approx(stopped, abs=0.02) and sea.state == "GUIDED"


@pytest.mark.parametrize("current", [(0.0, 0.0), (-0.3, 0.0), (0.0, 0.3), (0.2, 0.2)])
def test_loiter_stops_a_boat_and_keeps_its_place_in_a_current(
    current: tuple[float, float],
) -> None:
    sea = at_sea([at(40, 0)])
    sea.hull.current = current
    sea.run(3.0)
    sea.mode(AUTO)
    sea.run(20.0)
    assert sea.state == "AUTO"
    sea.mode(LOITER)
    sea.run(60.0)
    kept = place(sea)
    for _ in range(20):
        sea.run(3.0)
        assert sea.state == "LOITER" and place(sea) == pytest.approx(kept, abs=0.1)


def test_loiter_goes_on_from_formation_and_formation_from_loiter() -> None:
    sea = Afloat()
    sea.settle()
    sea.enter_formation()
    sea.run(2.0)
    assert acks(sea.mode(LOITER)) == [(SET_MODE, ACCEPTED)]
    sea.run(1.0)
    assert sea.state == "LOITER"
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, ACCEPTED)]
    sea.run(1.0)
    assert sea.state == "FORMATION"


@pytest.mark.parametrize("way", ["mode", "command", "standard mode", "PX4's"])
def test_each_form_of_request_brings_a_boat_home(way: str) -> None:
    sea = sailing([at(15, 0)])
    sea.run(20.0)
    order = {
        "mode": (SET_MODE, 1.0, 11.0),
        "command": (RETURN,),
        "standard mode": (STANDARD_MODE, 5.0),
        "PX4's": (SET_MODE, 129.0, 4.0, 5.0, *[math.nan] * 4),  # MAVSDK's return_to_launch()
    }[way]
    assert acks(sea.order(int(order[0]), *order[1:])) == [(order[0], ACCEPTED)]
    sea.run(60.0)
    assert sea.state == "RTL" and place(sea) == pytest.approx((0, 0), abs=0.05)


def test_home_is_where_the_boat_was_armed_last() -> None:
    sea = guided(10.0)
    sea.run(40.0)
    sea.disarm()
    sea.arm()
    sea.step()
    reposition(sea, at(20, 0))
    sea.run(40.0)
    sea.mode(RTL)
    sea.run(40.0)
    assert place(sea) == pytest.approx((10, 0), abs=0.05)


@pytest.mark.parametrize("mode", [RTL, AUTO])
def test_home_is_where_the_boat_is_armed_even_if_it_is_sent_home_in_the_same_tick(
    mode: int,
) -> None:
    sea = Afloat(hull=Hull(current=(1.0, 0.0)))
    sea.leader.on = False
    sea.run(20.0)
    sea.hull.current = (0.0, 0.0)
    sea.run(2.0)
    away = place(sea)[0]
    assert away > 15.0
    assert Planner(sea).send([at(away, 3), Item(RETURN, (0.0,) * 4, 0, 0, frame=2)]) is not None
    sea.say(command_long(ARM, 1.0), command_long(SET_MODE, 1.0, float(mode)))
    sea.run(40.0)
    assert place(sea)[0] == pytest.approx(away, abs=1.0)


def test_the_propellers_stop_where_the_own_state_is_lost() -> None:
    for number in (LOITER, RTL, GUIDED):
        sea = guided(15.0)
        sea.run(5.0)
        sea.mode(number)
        sea.run(1.0)
        sea.own.on = False
        sea.run(1.0)
        assert sea.state == "HOLD" and not any(sea.commands)
        sea.own.on = True
        sea.run(3.0)
        assert sea.state == "HOLD" and not any(sea.commands)


@pytest.mark.parametrize(
    ("parameters", "into"),
    [
        ({"FS_LEADER_ACT": 3}, "LOITER"),
        ({"FS_LEADER_ACT": 4}, "RTL"),
        ({"FS_LEADER_ACT": 1, "FS_COAST_ACT": 1, "FS_COAST_S": 1}, "LOITER"),
        ({"FS_LEADER_ACT": 1, "FS_COAST_ACT": 2, "FS_COAST_S": 1}, "RTL"),
    ],
)
def test_a_boat_that_loses_its_leader_waits_or_returns_as_chosen(
    parameters: dict[str, float], into: str
) -> None:
    sea = Afloat(parameters)
    sea.settle()
    sea.enter_formation()
    sea.run(5.0)
    sea.leader.on = False
    sea.run(4.0)
    assert sea.state == into
    sea.leader.on = True
    sea.run(5.0)
    assert sea.state == into  # it does not change by itself
    sea.mode(FORMATION)
    sea.run(1.0)
    assert sea.state == "FORMATION"


@pytest.mark.parametrize(("action", "into"), [(0, "HOLD"), (1, "LOITER"), (2, "RTL")])
def test_a_boat_at_its_fence_stops_waits_or_turns_back(action: int, into: str) -> None:
    sea = sailing([at(30, 0)], {"FS_FENCE_M": 10.0, "FS_FENCE_ACT": action})
    farthest = 0.0
    for _ in range(60):
        sea.run(1.0)
        farthest = max(farthest, place(sea)[0])
    assert sea.state == into and 9.0 < farthest < 13.0
    if into == "RTL":
        sea.run(30.0)
        assert place(sea) == pytest.approx((0, 0), abs=0.05)


def test_a_boat_comes_home_with_a_low_battery_if_it_may() -> None:
    sea = sailing(CORNER, {"FS_BATT_V": 22.0, "FS_BATT_ACT": 2})
    sea.run(15.0)
    assert sea.state == "AUTO"
    sea.escs[0].voltage = 20.0
    sea.run(60.0)
    assert sea.state == "RTL" and place(sea) == pytest.approx((0, 0), abs=0.05)


def test_a_rally_point_out_of_reach_does_not_keep_a_boat_from_home() -> None:
    sea = at_sea([])
    assert Planner(sea, kind=RALLY).send([rally(0, 4000)]) == ITEM_ACCEPTED
    reposition(sea, at(10, 0))
    sea.run(40.0)
    assert place(sea) == pytest.approx((10, 0), abs=0.5)
    sea.mode(RTL)
    sea.run(60.0)
    assert sea.state == "RTL" and place(sea) == pytest.approx((0, 0), abs=0.1)


def test_a_rally_point_beyond_the_circle_round_home_is_not_returned_to() -> None:
    sea = sailing([at(30, 0)], {"FS_FENCE_M": 20.0, "FS_FENCE_ACT": 2})
    sea.mode(HOLD)
    assert Planner(sea, kind=RALLY).send([rally(45, 0)]) == ITEM_ACCEPTED
    sea.mode(AUTO)
    sea.run(110.0)
    assert sea.state == "RTL" and place(sea) == pytest.approx((0, 0), abs=0.1)


def towed(north_m: float, rally_m: float) -> Afloat:
    """A boat in HOLD that was towed away from home, with a rally point."""
    sea = at_sea([])
    assert Planner(sea, kind=RALLY).send([rally(rally_m, 0)]) == ITEM_ACCEPTED
    while sea.hull.q[0] < north_m:
        sea.hull.q[3] = 12.0
        sea.step()
    sea.run(5.0)
    return sea


@pytest.mark.nightly
def test_a_boat_far_from_home_returns_to_a_rally_point() -> None:
    sea = towed(2880.0, 2930.0)
    assert acks(sea.mode(RTL)) == [(SET_MODE, ACCEPTED)]
    sea.run(90.0)
    assert sea.state == "RTL" and place(sea) == pytest.approx((2930, 0), abs=3.0)
    sea.mode(HOLD)
    sea.run(1.0)
    assert acks(sea.mode(RTL)) == [(SET_MODE, ACCEPTED)]
    sea.run(2.0)
    assert sea.state == "RTL"


def test_a_boat_is_not_sent_to_the_home_of_an_earlier_arming() -> None:
    sea = Afloat(hull=Hull())
    sea.leader.on = False
    sea.run(1.5)
    sea.arm()
    sea.run(0.3)
    sea.disarm()
    sea.own.on = False
    sea.run(1.5)
    sea.hull.q[0] = 100.0  # carried there
    sea.arm()
    sea.run(0.5)
    sea.own.on = True
    while sea.state != "RTL":
        sea.mode(RTL)
    sea.run(30.0)
    assert place(sea) == pytest.approx((100, 0), abs=0.5)


def test_another_component_of_the_leaders_system_neither_returns_nor_stays_for_it() -> None:
    sea = Sea({"RTL_ALONE": 1.0, "FORM_OFS_N": -3.0})
    sea.enter_formation()
    armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED | mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    camera = Station(sea.leader.station.system, 100)
    beats = {
        mode: mavlink.MAVLink_heartbeat_message(30, 0, armed, mode, 4, 3) for mode in (AUTO, RTL)
    }
    for _ in range(5):
        sea.say(beats[RTL], sender=camera)
        sea.run(0.1)
    assert sea.state == "FORMATION"
    for _ in range(3):
        beat = mavlink.MAVLink_heartbeat_message(11, 0, armed, RTL, 4, 3)
        sea.say(beat, sender=sea.leader.station)
        sea.say(beats[AUTO], sender=camera)
        sea.run(0.1)
    assert sea.state == "RTL"


@pytest.mark.parametrize(("alone", "into"), [(0.0, "FORMATION"), (1.0, "RTL")])
def test_a_boat_stays_behind_a_leader_that_returns_or_returns_alone(
    alone: float, into: str
) -> None:
    sea = Sea({"RTL_ALONE": alone, "FORM_OFS_N": -3.0})
    sea.enter_formation()
    armed = mavlink.MAV_MODE_FLAG_SAFETY_ARMED | mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
    steps = ((AUTO, "FORMATION"), (RTL, "FORMATION"), (RTL, "FORMATION"), (RTL, into))
    for mode, expected in steps:  # one report alone may be late
        beat = mavlink.MAVLink_heartbeat_message(11, 0, armed, mode, 4, 3)
        sea.say(beat, sender=sea.leader.station)
        sea.run(0.1)
        assert sea.state == expected
