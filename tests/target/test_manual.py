# SPDX-License-Identifier: MIT
"""MANUAL: the sticks drive the boat as long as they are sent."""

from __future__ import annotations

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.bus import FULL_SCALE
from tests.target.course import TURN
from tests.target.operator_words import (
    ENTER,
    drive,
    enter_manual,
    param_set,
    set_mode_message,
    sticks,
)
from tests.target.sea import Sea, acks, at_sea, named, texts
from tests.target.stations import (
    ACCEPTED,
    ARM,
    BOAT,
    DENIED,
    FORMATION,
    GCS,
    GCS_COMPONENT,
    HOLD,
    MANUAL,
    SET_MODE,
    TEMPORARILY_REJECTED,
    Station,
)
from tests.turns import some

SILENT_S = 0.5
CENTRE = "MANUAL: centre the sticks first"


def sign(value: int) -> int:
    return (value > 0) - (value < 0)


@pytest.mark.parametrize(
    ("x", "r", "port", "stbd"),
    [
        (300, 0, 1, 1),
        (-300, 0, -1, -1),
        (0, 300, 1, -1),
        (0, -300, -1, 1),
        (300, 300, 1, 0),
        (300, -300, 0, 1),
        (0, 0, 0, 0),
    ],
)
def test_each_stick_turns_the_propellers_its_way(
    sea: Sea, x: int, r: int, port: int, stbd: int
) -> None:
    """Ahead on +x, to starboard on +r: the port propeller pushes, the other one pulls."""
    enter_manual(sea)
    drive(sea, x, r)
    assert tuple(map(sign, sea.commands)) == (port, stbd)
    assert sea.snapshot()["thrust_N"] == pytest.approx(
        {"port": 20.0 * (x + r) / 1000, "stbd": 20.0 * (x - r) / 1000}, abs=0.01
    )


@pytest.mark.parametrize(
    ("x", "r", "share"),
    [
        (1000, 0, (1, 1)),
        (-1000, 0, (-1, -1)),
        (0, 1000, (1, -1)),
        (0, -1000, (-1, 1)),
        (1000, 1000, (1, -1)),
        (-1000, 1000, (0, -1)),
        (1000, 500, (1, 0)),
        (-1000, 500, (0, -1)),
    ],
)
def test_a_full_stick_gives_full_thrust_with_priority_to_yaw(
    sea: Sea, x: int, r: int, share: tuple[int, int]
) -> None:
    enter_manual(sea)
    drive(sea, x, r)
    assert sea.commands == pytest.approx([FULL_SCALE * s for s in share], abs=1)


def test_a_full_stick_gives_each_directions_own_greatest_thrust() -> None:
    sea = Sea({"THR_FWD_MAX": 30, "THR_REV_MAX": 12})
    enter_manual(sea)
    drive(sea, -1000)
    assert sea.snapshot()["thrust_N"] == pytest.approx({"port": -12, "stbd": -12}, rel=1e-3)
    drive(sea, 1000)
    assert sea.snapshot()["thrust_N"] == pytest.approx({"port": 30, "stbd": 30}, rel=1e-3)


def test_a_full_turn_without_surge_is_on_the_spot() -> None:
    sea = Sea({"THR_FWD_MAX": 30, "THR_REV_MAX": 12})
    enter_manual(sea)
    drive(sea, 0, 1000)
    assert sea.snapshot()["thrust_N"] == pytest.approx({"port": 12, "stbd": -12}, rel=1e-3)


def test_a_propeller_that_turns_the_other_way_gets_the_other_sign() -> None:
    sea = Sea({"THR_PORT_DIR": -1, "ESC_PORT": 3, "ESC_STBD": 1})
    enter_manual(sea)
    drive(sea, 500)
    half = sea.commands[1]
    assert half == pytest.approx(FULL_SCALE / 2, abs=1)
    assert sea.commands == (0, half, 0, -half)


def test_other_sticks_and_buttons_do_nothing(sea: Sea) -> None:
    enter_manual(sea)
    for others in ({"y": 1000}, {"z": 1000}, {"z": -32768}, {"buttons": 65535}, {"y": 32767}):
        for _ in range(10):
            sea.say(sticks(**others))
            sea.run(0.05)
            assert sea.state == "MANUAL" and sea.commands == (0, 0)


def test_the_heartbeat_shows_manual(sea: Sea) -> None:
    enter_manual(sea)
    beat = named(drive(sea, 0, 0, 1.2), "HEARTBEAT")[-1]
    assert (beat.custom_mode, beat.base_mode, beat.system_status) == (0, 1 | 64 | 128, 4)


@pytest.mark.parametrize("x", [0, 700])
def test_silent_sticks_lead_to_hold_within_half_a_second_and_a_tick(sea: Sea, x: int) -> None:
    enter_manual(sea)
    drive(sea, x)
    sea.say(sticks(x))
    said_us = sea.now_us
    while sea.state == "MANUAL":
        tick = sea.step()
        assert tick.now_us - said_us <= SILENT_S * 1e6 + sea.period_us
    assert tick.now_us - said_us >= SILENT_S * 1e6 - sea.period_us
    assert sea.state == "HOLD" and tick.commands == (0, 0)
    (text,) = tick.named("STATUSTEXT")
    assert text.text.startswith("HOLD: ") and "MANUAL_CONTROL" in text.text
    assert text.severity <= mavlink.MAV_SEVERITY_WARNING
    (beat,) = tick.named("HEARTBEAT")
    assert beat.custom_mode == HOLD
    drive(sea, x)
    assert sea.state == "HOLD" and sea.commands == (0, 0)


def test_sticks_that_come_back_in_time_keep_the_boat_in_manual(sea: Sea) -> None:
    enter_manual(sea)
    for _ in range(10):
        sea.say(sticks(200))
        sea.run(SILENT_S - 0.03)
        assert sea.state == "MANUAL" and all(c > 0 for c in sea.commands)


@pytest.mark.parametrize("axis", ["x", "r"])
@pytest.mark.parametrize("value", [32767, -32768, 1001, -1001, 20000])
def test_invalid_sticks_are_counted_and_ignored(sea: Sea, axis: str, value: int) -> None:
    enter_manual(sea)
    drive(sea, 200)
    driven, bad = sea.commands, sea.counter("mavlink_bad_value")
    for k in range(5):
        sea.say(sticks(**{axis: value}))
        sea.run(0.05)
        assert sea.commands == driven and sea.counter("mavlink_bad_value") == bad + k + 1
    for _ in range(10):
        sea.say(sticks(**{axis: value}))
        sea.run(0.05)
    assert sea.state == "HOLD"


@pytest.mark.parametrize("seed_state", ["HOLD", "FORMATION"])
def test_manual_without_sticks_is_refused_with_the_reason(seed_state: str) -> None:
    sea = Sea()
    ENTER[seed_state](sea)
    tick = sea.mode(MANUAL)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert [t for t in texts([tick]) if t.startswith("Refused: ") and "MANUAL_CONTROL" in t]
    assert sea.state == seed_state


def test_outdated_sticks_do_not_count(sea: Sea) -> None:
    sea.enter_hold()
    drive(sea, 500)
    sea.run(SILENT_S)
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert sea.state == "HOLD"


@pytest.mark.parametrize("state", ["DISARMED", "FAULT", "TEST"])
def test_manual_is_refused_in_states_that_do_not_allow_it(sea: Sea, state: str) -> None:
    ENTER[state](sea)
    sea.say(sticks(500))
    tick = sea.mode(MANUAL)
    assert acks(tick) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert any(t.startswith("Refused: ") for t in texts([tick]))
    assert sea.state == state


@pytest.mark.parametrize("state", ["DISARMED", "HOLD", "FAULT"])
def test_sticks_alone_never_turn_a_propeller(sea: Sea, state: str) -> None:
    ENTER[state](sea)
    ticks = drive(sea, 1000, 300, 3.0)
    assert sea.state == state and {t.commands for t in ticks} == {(0, 0)}


def test_sticks_do_not_disturb_a_boat_in_formation() -> None:
    quiet, disturbed = at_sea(), at_sea()
    quiet.run(2.0)
    drive(disturbed, -1000, 1000, 2.0)
    assert disturbed.state == "FORMATION"
    assert [t.commands for t in disturbed.ticks] == [t.commands for t in quiet.ticks]


def test_from_formation_to_manual_and_back(sea: Sea) -> None:
    sea.enter_formation()
    drive(sea, 250, 0, 0.2)
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, ACCEPTED)]
    drive(sea, 250)
    assert sea.state == "MANUAL" and not any(sea.commands), "not at neutral yet"
    drive(sea, 0, 0, 0.1)
    drive(sea, 250)
    assert sea.state == "MANUAL" and sea.commands == pytest.approx((2048, 2048), abs=1)
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, ACCEPTED)]
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, ACCEPTED)]
    sea.run(2.0)
    assert sea.state == "FORMATION"
    assert texts(sea.ticks) == ["HOLD", "FORMATION", "MANUAL", CENTRE, "FORMATION"]


def test_set_mode_requests_manual_without_an_ack(sea: Sea) -> None:
    sea.enter_hold()
    sea.say(sticks(), set_mode_message(MANUAL))
    assert not sea.step().named("COMMAND_ACK") and sea.state == "MANUAL"


def test_disarming_stops_the_sticks_in_the_same_tick(sea: Sea) -> None:
    enter_manual(sea)
    drive(sea, 1000)
    assert all(sea.commands)
    tick = sea.disarm()
    assert sea.state == "DISARMED" and tick.commands == (0, 0) and tick.arming[-1] == 0


def test_hold_stops_the_sticks_in_the_same_tick(sea: Sea) -> None:
    enter_manual(sea)
    drive(sea, 1000)
    tick = sea.mode(HOLD)
    assert sea.state == "HOLD" and tick.commands == (0, 0)


def test_a_boat_that_lost_its_navigation_can_be_driven_home(sea: Sea) -> None:
    enter_manual(sea)
    sea.silence("own")
    drive(sea, 300, 0, 3.0)
    assert not sea.condition("own_fresh")
    assert sea.state == "MANUAL" and all(c > 0 for c in sea.commands)
    assert acks(sea.mode(FORMATION)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert sea.state == "MANUAL"


def test_manual_can_be_asked_for_after_the_navigation_was_lost_in_formation() -> None:
    sea = at_sea()
    sea.silence("own")
    sea.run_until("HOLD", 1.0)
    sea.run(5.0)
    drive(sea, 0, 0, 0.1)
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, ACCEPTED)]
    drive(sea, -300)
    assert sea.state == "MANUAL" and all(c < 0 for c in sea.commands)


def test_manual_needs_no_leader(sea: Sea) -> None:
    sea.leader.on = False
    enter_manual(sea)
    drive(sea, 300, 0, 3.0)
    assert sea.state == "MANUAL" and all(sea.commands)


@pytest.mark.parametrize("esc", [0, 1])
def test_a_lost_esc_is_a_fault_in_manual_too(sea: Sea, esc: int) -> None:
    enter_manual(sea)
    drive(sea, 300)
    sea.escs[esc].on = False
    for _ in range(40):
        if drive(sea, 300, 0, 0.05) and sea.state == "FAULT":
            break
    assert sea.state == "FAULT" and sea.commands == (0, 0)
    sea.escs[esc].on = True
    drive(sea, 300, 0, 3.0)
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert sea.state == "FAULT" and sea.commands == (0, 0)


def test_a_bus_that_goes_down_is_a_fault_in_manual_too(sea: Sea) -> None:
    enter_manual(sea)
    drive(sea, 300)
    sea.boat.on_host(bus_up=False)
    assert sea.step().commands == (0, 0) and sea.state == "FAULT"


def test_only_the_ground_station_of_mav_gcs_sysid_holds_the_sticks() -> None:
    sea = Sea({"MAV_GCS_SYSID": 250})
    ours, stranger = Station(250, 190), Station(GCS, GCS_COMPONENT)
    sea.gcs = ours
    sea.enter_hold()
    drive(sea, 900, 0, 0.5, sender=stranger)
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    drive(sea, 300, 0, 0.2)
    sea.gcs = stranger
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, DENIED)]
    sea.say(set_mode_message(MANUAL))
    sea.step()
    assert sea.state == "HOLD"
    sea.gcs = ours
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, ACCEPTED)]
    drive(sea, 300)
    driven = sea.commands
    for _ in range(8):  # his own sticks go on, the stranger's are louder
        sea.say(sticks(300))
        sea.say(sticks(-1000, 1000), sender=stranger)
        assert sea.step().commands == driven
    drive(sea, 300, 0, 0.6, sender=stranger)
    assert sea.state == "HOLD"


@pytest.mark.parametrize("target", [BOAT + 1, GCS])
def test_sticks_of_another_boat_are_not_this_ones(sea: Sea, target: int) -> None:
    sea.enter_hold()
    sea.say(sticks(500, target=target))
    assert acks(sea.mode(MANUAL)) == [(SET_MODE, TEMPORARILY_REJECTED)]


def test_after_arming_the_escs_see_zeros_before_the_sticks_drive(sea: Sea) -> None:
    sea.settle()
    sea.say(sticks(0))
    armed_us = sea.arm().now_us
    sea.mode(MANUAL)
    assert sea.state == "MANUAL"
    ticks = drive(sea, 1000)
    for tick in some(t for t in ticks if t.now_us - armed_us < 150_000):
        assert tick.commands == (0, 0)
    assert all(sea.commands)


def test_the_sticks_move_the_propellers_no_faster_than_thr_slew() -> None:
    sea = Sea({"THR_SLEW": 2})
    enter_manual(sea)
    most = FULL_SCALE * 2 * sea.period_us * 1e-6 + 1
    before: tuple[int, ...] = (0, 0)
    for tick in [*drive(sea, 1000), *drive(sea, -1000, 0, 1.5)]:
        assert all(abs(a - b) <= most for a, b in zip(tick.commands, before, strict=True))
        before = tick.commands
    assert before == (-FULL_SCALE, -FULL_SCALE)


def test_in_manual_a_boat_says_where_it_is() -> None:
    sea = Sea(own=TURN)
    enter_manual(sea)
    ticks = drive(sea, 100, 0, 2.0)
    assert len(named(ticks, "LOCAL_POSITION_NED")) in range(19, 22)
    sea.say(param_set("FORM_OFS_N", 3.0))
    sea.step()
    assert sea.state == "MANUAL" and sea.boat.parameters()["FORM_OFS_N"] == 3.0


def test_arming_again_in_manual_changes_nothing(sea: Sea) -> None:
    enter_manual(sea)
    drive(sea, 400)
    assert acks(sea.arm()) == [(ARM, ACCEPTED)]
    assert sea.state == "MANUAL" and all(sea.commands)
