# SPDX-License-Identifier: MIT
"""DO_MOTOR_TEST: one propeller, little thrust, a short time."""

from __future__ import annotations

import math

import pytest

from tests.target.bus import FULL_SCALE
from tests.target.operator_words import ENTER, PORT, STBD, command_int, enter_test, sticks
from tests.target.sea import Sea, Tick, acks, named, texts
from tests.target.stations import (
    ACCEPTED,
    ARM,
    DENIED,
    FORMATION,
    HOLD,
    MANUAL,
    MOTOR_TEST,
    SET_MODE,
    TEMPORARILY_REJECTED,
    TERMINATE,
    Station,
    command_long,
)

PERCENT = 0.0  # MOTOR_TEST_THROTTLE_PERCENT
BOTH = pytest.mark.parametrize("propeller", [PORT, STBD], ids=["port", "stbd"])


def of(propeller: float, tick: Tick) -> int:
    """The command of the propeller under test; asserts that the other one is stopped."""
    tested, other = tick.commands if propeller == PORT else tick.commands[::-1]
    assert other == 0
    return tested


def thrust_share(command: int, expo: float) -> float:
    """T / T_max of a raw command, by the thrust curve's definition."""
    c = command / FULL_SCALE
    return (1 - expo) * c + expo * c * abs(c)


@BOTH
@pytest.mark.parametrize("percent", [20.0, 5.0, 0.5, -5.0, -20.0])
@pytest.mark.parametrize("expo", [0.0, 0.6, 1.0])
def test_a_motor_test_gives_the_share_of_one_propellers_thrust_that_was_asked(
    propeller: float, percent: float, expo: float
) -> None:
    sea = Sea({"THR_EXPO": expo, "THR_FWD_MAX": 30, "THR_REV_MAX": 12, "THR_SLEW": 0})
    enter_test(sea, propeller, PERCENT, percent, 1.0)
    sea.step()
    for tick in sea.run(0.9):
        share = thrust_share(of(propeller, tick), expo)
        assert abs(share) <= 0.2 + 1e-6
        assert share == pytest.approx(percent / 100, abs=3e-4)
    thrust = sea.snapshot()["thrust_N"]["port" if propeller == PORT else "stbd"]
    assert thrust == pytest.approx(percent / 100 * (30 if percent > 0 else 12), abs=0.01)


@BOTH
def test_a_motor_test_starts_no_faster_than_thr_slew_and_stops_at_once(propeller: float) -> None:
    sea = Sea({"THR_SLEW": 0.5})
    enter_test(sea, propeller, PERCENT, 20.0, 1.0)
    before = 0
    for tick in [sea.ticks[-1], *sea.run(0.9)]:
        assert of(propeller, tick) - before <= 0.5 * FULL_SCALE * sea.period_us * 1e-6 + 1
        before = of(propeller, tick)
    assert before == pytest.approx(0.2 * FULL_SCALE, abs=1)
    sea.run(0.2)
    ends = [t.commands for t in sea.ticks[-30:]]
    assert ends[-1] == (0, 0) and sum(1 for c in ends if c not in ((0, 0), ends[0])) == 0


@BOTH
@pytest.mark.parametrize("seconds", [0.1, 0.5, 2.345, 5.0])
def test_a_motor_test_lasts_as_long_as_was_asked(
    sea: Sea, propeller: float, seconds: float
) -> None:
    enter_test(sea, propeller, PERCENT, 10.0, seconds)
    began_us = sea.ticks[-1].now_us
    sea.run(6.0)
    turned = [t.now_us for t in sea.ticks if any(t.commands)]
    assert turned[0] - began_us <= sea.period_us
    assert turned[-1] - began_us == pytest.approx(seconds * 1e6, abs=1.5 * sea.period_us)
    assert turned[-1] - turned[0] == (len(turned) - 1) * sea.period_us
    assert sea.state == "HOLD"


def test_the_end_of_a_motor_test_is_reported(sea: Sea) -> None:
    enter_test(sea, PORT, PERCENT, 10.0, 1.0)
    (beat,) = sea.ticks[-1].named("HEARTBEAT")
    assert (beat.custom_mode, beat.base_mode, beat.system_status) == (4, 1 | 2 | 128, 4)
    ticks = sea.run(1.5)
    (changed,) = [m for m in named(ticks, "HEARTBEAT") if m.base_mode == 1 | 128][:1]
    assert (changed.custom_mode, changed.system_status) == (4, 4)
    said = texts(sea.ticks)
    assert said[:2] == ["HOLD", "TEST"] and len(said) == 3 and said[2].startswith("HOLD")


def test_the_end_of_a_motor_test_as_asked_is_no_error(sea: Sea) -> None:
    """Ground stations read errors aloud."""
    enter_test(sea, PORT, PERCENT, 10.0, 0.5)
    (said,) = named(sea.run(1.0), "STATUSTEXT")
    assert said.severity > 4


@pytest.mark.parametrize(
    "params",
    [
        (0.0, PERCENT, 10.0, 1.0),
        (3.0, PERCENT, 10.0, 1.0),
        (-1.0, PERCENT, 10.0, 1.0),
        (1.5, PERCENT, 10.0, 1.0),
        (math.nan, PERCENT, 10.0, 1.0),
        (math.inf, PERCENT, 10.0, 1.0),
        (PORT, 1.0, 1500.0, 1.0),
        (PORT, 1.0, 10.0, 1.0),
        (PORT, 2.0, 10.0, 1.0),
        (PORT, 3.0, 10.0, 1.0),
        (PORT, PERCENT, 20.01, 1.0),
        (PORT, PERCENT, 100.0, 1.0),
        (PORT, PERCENT, -20.01, 1.0),
        (PORT, PERCENT, math.nan, 1.0),
        (PORT, PERCENT, math.inf, 1.0),
        (PORT, PERCENT, 10.0, 5.01),
        (PORT, PERCENT, 10.0, 1e30),
        (PORT, PERCENT, 10.0, -0.1),
        (PORT, PERCENT, 10.0, math.nan),
        (PORT, PERCENT, 10.0, math.inf),
        (PORT, PERCENT, 10.0, 1.0, 2.0),
        (PORT, PERCENT, 10.0, 1.0, -1.0),
        (PORT, PERCENT, 10.0, 1.0, 0.5),
        (PORT,),
        (),
    ],
    ids=str,
)
def test_a_motor_test_that_is_too_much_or_makes_no_sense_is_denied(
    sea: Sea, params: tuple[float, ...]
) -> None:
    sea.enter_hold()
    sea.run(0.3)
    tick = sea.order(MOTOR_TEST, *params)
    assert acks(tick) == [(MOTOR_TEST, DENIED)]
    assert {t.commands for t in [tick, *sea.run(0.5)]} == {(0, 0)} and sea.state == "HOLD"


@pytest.mark.parametrize(("percent", "seconds"), [(0.0, 1.0), (10.0, 0.0)])
def test_a_motor_test_of_zero_turns_no_propeller(sea: Sea, percent: float, seconds: float) -> None:
    sea.enter_hold()
    sea.run(0.3)
    tick = sea.order(MOTOR_TEST, PORT, PERCENT, percent, seconds)
    assert {t.commands for t in [tick, *sea.run(2.0)]} == {(0, 0)} and sea.state == "HOLD"


@pytest.mark.parametrize("count", [math.nan, 0.0, 1.0])
@pytest.mark.parametrize("order", [math.nan, 0.0, 2.0])
def test_a_test_of_one_motor_is_accepted_in_any_order(sea: Sea, count: float, order: float) -> None:
    sea.enter_hold()
    sea.run(0.3)
    tick = sea.order(MOTOR_TEST, PORT, PERCENT, 10.0, 1.0, count, order)
    assert acks(tick) == [(MOTOR_TEST, ACCEPTED)] and sea.state == "TEST"


def test_a_command_int_asks_for_a_motor_test_too(sea: Sea) -> None:
    sea.enter_hold()
    sea.run(0.3)
    sea.say(command_int(MOTOR_TEST, STBD, PERCENT, -10.0, 1.0, x=1))
    assert acks(sea.step()) == [(MOTOR_TEST, ACCEPTED)]
    sea.run(0.5)
    assert of(STBD, sea.ticks[-1]) == pytest.approx(-0.1 * FULL_SCALE, abs=1)


@pytest.mark.parametrize(
    ("state", "why"),
    [("DISARMED", "arm"), ("FORMATION", "HOLD"), ("MANUAL", "HOLD"), ("FAULT", "FAULT")],
)
def test_only_a_boat_in_hold_is_tested(sea: Sea, state: str, why: str) -> None:
    ENTER[state](sea)
    tick = sea.order(MOTOR_TEST, PORT, PERCENT, 10.0, 1.0)
    assert acks(tick) == [(MOTOR_TEST, TEMPORARILY_REJECTED)]
    assert any(t.startswith("Refused: ") and why in t for t in texts([tick]))
    assert sea.state == state


@pytest.mark.parametrize("waited_s", [0.02, 0.5, 0.9])
def test_a_repeated_order_is_accepted_and_does_not_lengthen_the_test(
    sea: Sea, waited_s: float
) -> None:
    enter_test(sea, STBD, PERCENT, 10.0, 1.0)
    began_us = sea.ticks[-1].now_us
    sea.run(waited_s)
    for confirmation in (1, 2):
        tick = sea.order(MOTOR_TEST, STBD, PERCENT, 10.0, 1.0, confirmation=confirmation)
        assert acks(tick) == [(MOTOR_TEST, ACCEPTED)] and sea.state == "TEST"
    sea.run(2.0)
    turned = [t.now_us for t in sea.ticks if any(t.commands)]
    assert turned[-1] - began_us == pytest.approx(1e6, abs=1.5 * sea.period_us)
    assert texts(sea.ticks).count("TEST") == 1


def test_a_second_test_comes_after_the_first_has_ended(sea: Sea) -> None:
    for propeller in (PORT, STBD, STBD):
        if sea.state == "DISARMED":
            sea.enter_hold()
            sea.run(0.3)
        assert acks(sea.order(MOTOR_TEST, propeller, PERCENT, 10.0, 0.5)) == [
            (MOTOR_TEST, ACCEPTED)
        ]
        ticks = sea.run(1.0)
        assert any(of(propeller, t) for t in ticks) and sea.state == "HOLD"


@pytest.mark.parametrize(
    "other",
    [(STBD, PERCENT, 10.0, 1.0), (PORT, PERCENT, -10.0, 1.0), (PORT, PERCENT, 10.0, 5.0)],
    ids=["propeller", "direction", "duration"],
)
def test_a_motor_test_requested_during_another_is_rejected_and_does_not_extend_it(
    sea: Sea, other: tuple[float, ...]
) -> None:
    """A test can begin in HOLD only, not while another one runs."""
    enter_test(sea, PORT, PERCENT, 10.0, 1.0)
    sea.run(0.5)
    tick = sea.order(MOTOR_TEST, *other)
    ticks = [tick, *sea.run(2.0)]
    assert not [t.commands for t in ticks if all(t.commands)]
    assert acks(tick) == [(MOTOR_TEST, TEMPORARILY_REJECTED)]
    assert max(of(PORT, t) for t in ticks) > 0 and min(of(PORT, t) for t in ticks) == 0


def test_a_repeated_order_is_refused_once_the_boat_is_disarmed(sea: Sea) -> None:
    enter_test(sea, PORT, PERCENT, 10.0, 5.0)
    sea.disarm()
    tick = sea.order(MOTOR_TEST, PORT, PERCENT, 10.0, 5.0, confirmation=1)
    assert acks(tick) == [(MOTOR_TEST, TEMPORARILY_REJECTED)] and sea.state == "DISARMED"


def test_a_late_repetition_of_an_order_does_not_begin_a_second_test(sea: Sea) -> None:
    """The ACK was lost and the test is short: 0.5 s later it is already over."""
    enter_test(sea, PORT, PERCENT, 10.0, 0.3)
    sea.run(0.5)
    assert sea.state == "HOLD"
    tick = sea.order(MOTOR_TEST, PORT, PERCENT, 10.0, 0.3, confirmation=1)
    assert acks(tick) == [(MOTOR_TEST, ACCEPTED)]
    assert {t.commands for t in [tick, *sea.run(1.0)]} == {(0, 0)}


@pytest.mark.parametrize(
    ("order", "state"),
    [((SET_MODE, 1.0, float(HOLD)), "HOLD"), ((ARM, 0.0), "DISARMED"), ((TERMINATE, 1.0), "FAULT")],
)
def test_the_operator_ends_a_motor_test_in_the_same_tick(
    sea: Sea, order: tuple[int, ...], state: str
) -> None:
    enter_test(sea)
    sea.run(0.5)
    assert any(sea.commands)
    tick = sea.order(*order)
    assert acks(tick) == [(order[0], ACCEPTED)]
    assert sea.state == state and {t.commands for t in [tick, *sea.run(6.0)]} == {(0, 0)}
    assert sea.state == state


@pytest.mark.parametrize("mode", [FORMATION, MANUAL])
def test_a_mode_that_drives_is_rejected_during_a_motor_test(sea: Sea, mode: int) -> None:
    enter_test(sea)
    sea.say(sticks(500))
    assert acks(sea.mode(mode)) == [(SET_MODE, TEMPORARILY_REJECTED)]
    assert sea.state == "TEST"


def test_a_lost_esc_ends_a_motor_test_with_a_fault(sea: Sea) -> None:
    enter_test(sea)
    sea.run(0.2)
    sea.escs[1].on = False
    sea.run_until("FAULT", 2.0)
    assert {t.commands for t in sea.run(5.0)} == {(0, 0)} and sea.state == "FAULT"


def test_a_bus_that_goes_down_ends_a_motor_test_with_a_fault(sea: Sea) -> None:
    enter_test(sea)
    sea.boat.on_host(bus_up=False)
    assert sea.step().commands == (0, 0) and sea.state == "FAULT"


@pytest.mark.parametrize("lost", ["own", "leader"])
def test_a_motor_test_needs_neither_navigation_nor_leader(sea: Sea, lost: str) -> None:
    sea.enter_hold()
    sea.silence(lost)
    sea.run(2.0)
    assert acks(sea.order(MOTOR_TEST, PORT, PERCENT, 10.0, 1.0)) == [(MOTOR_TEST, ACCEPTED)]
    sea.run(0.5)
    assert of(PORT, sea.ticks[-1]) > 0


@BOTH
def test_a_reversed_propeller_is_tested_reversed(propeller: float) -> None:
    sea = Sea({"THR_PORT_DIR": -1, "THR_STBD_DIR": -1})
    enter_test(sea, propeller, PERCENT, 10.0, 1.0)
    sea.run(0.5)
    assert of(propeller, sea.ticks[-1]) == pytest.approx(-0.1 * FULL_SCALE, abs=1)


def test_the_propeller_is_the_one_behind_its_esc_index() -> None:
    sea = Sea({"ESC_PORT": 4, "ESC_STBD": 2})
    enter_test(sea, PORT, PERCENT, 10.0, 1.0)
    sea.run(0.5)
    assert [k for k, c in enumerate(sea.commands) if c] == [4]


def test_after_arming_the_escs_see_zeros_before_a_test_too(sea: Sea) -> None:
    sea.settle()
    armed_us = sea.arm().now_us
    sea.order(MOTOR_TEST, PORT, PERCENT, 10.0, 1.0)
    assert sea.state == "TEST"
    turned = [t.now_us for t in sea.run(1.5) if any(t.commands)]
    assert turned and turned[0] - armed_us >= 150_000
    assert turned[-1] - armed_us <= 1.05e6


def test_a_strangers_motor_test_is_denied() -> None:
    sea = Sea({"MAV_GCS_SYSID": 250})
    sea.gcs = Station(250, 190)
    sea.enter_hold()
    sea.run(0.3)
    sea.say(command_long(MOTOR_TEST, PORT, PERCENT, 10.0, 1.0), sender=Station(255, 190))
    assert acks(sea.step()) == [(MOTOR_TEST, DENIED)] and sea.state == "HOLD"


@BOTH
@pytest.mark.parametrize("percent", [9.9, 1.0, -9.9])
def test_a_thrust_that_the_boat_would_command_as_zero_is_no_test(
    propeller: float, percent: float
) -> None:
    """The dead zone is 2 N of 20 N; a propeller that does not turn looks broken."""
    sea = Sea({"THR_DEAD": 2})
    sea.enter_hold()
    sea.run(0.6)
    tick = sea.order(MOTOR_TEST, propeller, PERCENT, percent, 1.0)
    assert acks(tick) == [(MOTOR_TEST, DENIED)]
    assert texts([tick]) == ["Refused: test thrust is below THR_DEAD"]
    assert {t.commands for t in [tick, *sea.run(1.0)]} == {(0, 0)} and sea.state == "HOLD"
    tick = sea.order(MOTOR_TEST, propeller, PERCENT, math.copysign(10.2, percent), 1.0)
    assert acks(tick) == [(MOTOR_TEST, ACCEPTED)]
    sea.run(0.5)
    assert abs(of(propeller, sea.ticks[-1])) == pytest.approx(0.102 * FULL_SCALE, abs=1)


def test_astern_the_dead_zone_is_a_larger_share_of_a_smaller_thrust() -> None:
    sea = Sea({"THR_DEAD": 2, "THR_FWD_MAX": 40, "THR_REV_MAX": 12})
    sea.enter_hold()
    sea.run(0.6)
    for percent, result in ((10.0, ACCEPTED), (-10.0, DENIED), (-17.0, ACCEPTED)):
        assert acks(sea.order(MOTOR_TEST, PORT, PERCENT, percent, 0.2)) == [(MOTOR_TEST, result)]
        sea.run(0.6)


@pytest.mark.parametrize("state", ["DISARMED", "FORMATION", "MANUAL", "FAULT"])
def test_a_test_below_the_dead_zone_is_refused_in_every_state(state: str) -> None:
    sea = Sea({"THR_DEAD": 2})
    ENTER[state](sea)
    tick = sea.order(MOTOR_TEST, PORT, PERCENT, 5.0, 1.0)
    assert acks(tick)[0][1] in (DENIED, TEMPORARILY_REJECTED)
    assert any(t.startswith("Refused: ") for t in texts([tick])) and sea.state == state
