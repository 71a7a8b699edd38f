# SPDX-License-Identifier: MIT
"""ESC and battery telemetry as an operator sees it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import pytest

from tests.target.bus import Frames, esc_status, node_status
from tests.target.sea import Sea
from tests.turns import some

UNKNOWN_VOLTAGE, UNKNOWN_CURRENT, UNKNOWN_TEMPERATURE = 65535, -1, 32767


@dataclass
class Bench:
    """A boat whose ESCs measure given values."""

    sea: Sea
    measured: list[dict[str, Any]]
    indices: tuple[int, int] = (0, 1)
    sent: int = 0

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 10)):
            frames: Frames = []
            for node, index, what in zip((31, 32), self.indices, self.measured, strict=True):
                frames += node_status(node, 100 + self.sent // 10, self.sent % 32)
                frames += esc_status(node, index, self.sent % 32, **what)
            self.sent += 1
            self.sea.on_can(frames)
            self.sea.run(0.1)


def bench(port: dict[str, Any], stbd: dict[str, Any], indices: tuple[int, int] = (0, 1)) -> Bench:
    sea = Sea({"ESC_PORT": indices[0], "ESC_STBD": indices[1]})
    for esc in sea.escs:
        esc.on = False
    found = Bench(sea, [port, stbd], indices)
    found.run(1.0)
    return found


NAN = math.nan


@pytest.mark.parametrize(
    ("volts", "amperes", "voltage_mV", "current_cA"),
    [
        ((24.0, 24.0), (1.5, 2.5), 24000, 400),
        ((23.0, 25.0), (0.0, 0.0), 23000, 0),
        ((25.0, 23.0), (0.0, 4.0), 23000, 400),
        ((NAN, 23.0), (NAN, NAN), 23000, UNKNOWN_CURRENT),
        ((25.0, NAN), (2.0, 2.0), 25000, 400),
        ((NAN, NAN), (NAN, NAN), UNKNOWN_VOLTAGE, UNKNOWN_CURRENT),
        ((math.inf, math.inf), (math.inf, math.inf), UNKNOWN_VOLTAGE, UNKNOWN_CURRENT),
        ((65504.0, -65504.0), (65504.0, -65504.0), UNKNOWN_VOLTAGE, UNKNOWN_CURRENT),
    ],
)
def test_the_battery_has_the_voltage_and_current_that_the_escs_report(
    volts: tuple[float, float], amperes: tuple[float, float], voltage_mV: int, current_cA: int
) -> None:
    port, stbd = ({"voltage": v, "current": a} for v, a in zip(volts, amperes, strict=True))
    sea = bench(port, stbd).sea
    (status,) = sea.ask(1)
    assert (status.voltage_battery, status.current_battery) == (voltage_mV, current_cA)
    assert status.battery_remaining == -1
    (battery,) = sea.ask(147)
    assert list(battery.voltages) == [voltage_mV] + [65535] * 9
    assert battery.current_battery == current_cA
    assert (battery.current_consumed, battery.energy_consumed) == (-1, -1)
    assert (battery.battery_remaining, battery.temperature) == (-1, UNKNOWN_TEMPERATURE)


def test_a_silent_escs_battery_is_unknown(sea: Sea) -> None:
    sea.run(1.0)
    (status,) = sea.ask(1)
    assert (status.voltage_battery, status.current_battery) == (24500, 250)
    sea.escs[0].on = sea.escs[1].on = False
    sea.run(5.0)
    (status,) = sea.ask(1)
    assert status.voltage_battery == UNKNOWN_VOLTAGE
    assert status.current_battery == UNKNOWN_CURRENT
    (info,) = sea.ask(290)
    assert info.info == 0 and set(info.temperature) == {UNKNOWN_TEMPERATURE}


PORT = {"rpm": 1200, "voltage": 24.5, "current": 1.25, "temperature": 300.0, "error_count": 7}
STBD = {"rpm": -800, "voltage": 23.75, "current": 2.5, "temperature": 310.0, "error_count": 2**31}


@pytest.mark.parametrize("indices", [(0, 1), (1, 0), (2, 5), (7, 4), (19, 0)], ids=str)
def test_esc_messages_describe_groups_of_four_propellers(indices: tuple[int, int]) -> None:
    sea = bench(PORT, STBD, indices).sea
    groups = list(dict.fromkeys(k // 4 * 4 for k in indices))
    for message_id in (290, 291):
        told = sea.ask(message_id)
        assert [m.index for m in told] == groups
        assert len({m.time_usec for m in told}) == 1
        for m in told:
            for slot in range(4):
                kind = {indices[0]: PORT, indices[1]: STBD}.get(m.index + slot)
                if message_id == 291:
                    shown = m.rpm[slot], m.voltage[slot], m.current[slot]
                    assert shown == (
                        (kind["rpm"], kind["voltage"], kind["current"]) if kind else (0, 0, 0)
                    )
                else:
                    assert m.info >> slot & 1 == (kind is not None)
                    assert m.error_count[slot] == (kind["error_count"] if kind else 0)
                    expected: Any = UNKNOWN_TEMPERATURE
                    if kind:
                        expected = pytest.approx((kind["temperature"] - 273.15) * 100, abs=25)
                    assert m.temperature[slot] == expected
                    assert m.connection_type == 5 and not any(m.failure_flags)


@pytest.mark.parametrize(("indices", "least"), [((0, 1), 2), ((2, 5), 6), ((19, 0), 20)], ids=str)
def test_a_client_does_not_ignore_a_propeller(indices: tuple[int, int], least: int) -> None:
    """ESC_INFO.count: "fields with an index higher than this should be ignored"."""
    for info in some(bench(PORT, STBD, indices).sea.ask(290)):
        assert info.count >= least


def test_a_propeller_whose_esc_is_silent_is_not_shown_as_online(sea: Sea) -> None:
    sea.run(1.0)
    (info,) = sea.ask(290)
    assert info.info == 0b11
    sea.escs[0].on = False
    sea.run(5.0)
    (info,) = sea.ask(290)
    assert info.info == 0b10
