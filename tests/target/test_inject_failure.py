# SPDX-License-Identifier: MIT
"""MAV_CMD_INJECT_FAILURE: an operator injects failures around a simulated boat."""

from __future__ import annotations

from typing import Any

import flotilla
import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.stations import ACCEPTED, DENIED, UNSUPPORTED
from tests.target.troubled_fleet import NAVIGATION, heard, messages, records_of
from tests.target.twin_fleets import EXACT, H_US, LOCAL

INJECT = mavlink.MAV_CMD_INJECT_FAILURE
GPS, MOTOR = mavlink.FAILURE_UNIT_SENSOR_GPS, mavlink.FAILURE_UNIT_SYSTEM_MOTOR
SIGNAL = mavlink.FAILURE_UNIT_SYSTEM_MAVLINK_SIGNAL
OK, OFF, STUCK = mavlink.FAILURE_TYPE_OK, mavlink.FAILURE_TYPE_OFF, mavlink.FAILURE_TYPE_STUCK
GARBAGE, WRONG = mavlink.FAILURE_TYPE_GARBAGE, mavlink.FAILURE_TYPE_WRONG
INTERMITTENT = mavlink.FAILURE_TYPE_INTERMITTENT

KNOWN = {
    (GPS, OFF): ("own_silent", 0.0),
    (GPS, STUCK): ("own_frozen", 0.0),
    (GPS, WRONG): ("own_jump", 20.0),
    (MOTOR, OFF): ("esc_reboot", 0.0),
    (MOTOR, STUCK): ("esc_stuck", 0.0),
    (MOTOR, WRONG): ("esc_reversed", 0.0),
    (SIGNAL, OFF): ("radio_silent", 0.0),
    (SIGNAL, GARBAGE): ("byte_errors", 0.1),
    (SIGNAL, INTERMITTENT): ("radio_loss", 0.5),
}


class Sea:
    """A boat commanded from outside, and its follower."""

    def __init__(self, *, inject_failures: bool = True) -> None:
        self.fleet: Any = flotilla.Fleet(record=True, inject_failures=inject_failures)
        for i in (1, 2):
            own = {"MAV_SYSID": i, "FORM_LEADER": 3 - i}
            self.fleet.add_boat(0, own, LOCAL, EXACT)
        self.fleet.connect(0, 1)
        self.fleet.connect(1, 0)
        self.t_us = 0
        self.tick(50)

    def tick(self, ticks: int = 1) -> None:
        for _ in range(ticks):
            place = np.full((2, 3), 1e-7 * self.t_us)
            self.fleet.tick(self.t_us, place, place, None, np.zeros((2, 2)), np.empty((2, 2)))
            self.t_us += H_US

    def inject(self, unit: float, kind: float, instance: float = 0.0) -> int:
        """Inject a failure; the MAV_RESULT."""
        self.fleet.command([0], self.t_us, INJECT, (unit, kind, instance))
        self.tick()
        (ack,) = messages([(0, self.fleet.sent(0))], "COMMAND_ACK")
        assert ack.command == INJECT
        return int(ack.result)

    def north(self) -> float:
        """The position, m north, that the boat's unit sent with the last tick."""
        _, data = heard(records_of(self.fleet), 0, NAVIGATION)[-1]
        (place,) = messages([(0, data)], "LOCAL_POSITION_NED")
        return float(place.x)


def test_only_known_failures_are_injected() -> None:
    sea = Sea()
    for unit in (*range(9), *range(100, 106), 255):
        for kind in range(9):
            fits = (unit, kind) in KNOWN or (kind == OK and unit in (GPS, MOTOR, SIGNAL))
            assert sea.inject(unit, kind) == (ACCEPTED if fits else UNSUPPORTED), (unit, kind)
            if fits and unit == SIGNAL:
                sea.fleet.clear_fault(0, KNOWN.get((unit, kind), ("radio_silent", 0))[0], sea.t_us)
    for unit in (GPS, SIGNAL):
        assert [sea.inject(unit, OK, n) for n in (1, 2)] == [ACCEPTED, DENIED]
    assert [sea.inject(MOTOR, OK, n) for n in (1, 2, 3)] == [ACCEPTED, ACCEPTED, DENIED]
    assert sea.inject(0.5, OFF) == UNSUPPORTED


def test_no_failure_is_injected_without_leave() -> None:
    sea = Sea(inject_failures=False)
    for unit, kind in KNOWN:
        assert sea.inject(unit, kind) == UNSUPPORTED
    sea.tick(10)
    assert sea.fleet.snapshot(0)["conditions"]["own_fresh"]


@pytest.mark.parametrize("instance", [0, 1, 2])
@pytest.mark.parametrize(("unit", "kind"), KNOWN)
def test_an_injected_failure_is_the_fault_that_a_scenario_sets(
    unit: int, kind: int, instance: int
) -> None:
    """Equal, from beginning to end, to a scenario's fault set after the same tick."""
    if instance == 2 and unit != MOTOR:
        return
    fault, value = KNOWN[unit, kind]
    esc = {"esc": (None, "port", "stbd")[instance]} if unit == MOTOR else {}
    histories = []
    for by_command in (True, False):
        sea = Sea()
        # the other boat gets a command of equal length without effect
        sea.inject(unit, kind if by_command else OK, instance)
        if not by_command:
            sea.fleet.set_fault(0, fault, sea.t_us - H_US, value=value, **esc)
        sea.fleet.take_records(0)
        sea.tick(60)
        histories.append(sea.fleet.take_records(0))
    assert histories[0] == histories[1]
    sea.fleet.clear_fault(0, fault, sea.t_us, **esc)


def test_a_failure_takes_the_place_of_the_last_one_and_ok_ends_it() -> None:
    sea = Sea()
    sea.inject(GPS, OFF)
    sea.tick(60)
    assert not sea.fleet.snapshot(0)["conditions"]["own_fresh"]
    sea.inject(GPS, WRONG)
    sea.tick(60)
    assert sea.fleet.snapshot(0)["conditions"]["own_fresh"]
    assert sea.north() == pytest.approx(1e-7 * sea.t_us + 20.0, abs=0.01)
    sea.inject(GPS, OK)
    sea.tick()
    assert sea.north() == pytest.approx(1e-7 * sea.t_us, abs=0.01)
