# SPDX-License-Identifier: MIT
"""A fleet's propellers turn and stop exactly when those of single boats do."""

from __future__ import annotations

from typing import Any

import pytest

from sil.wire.dronecan import RAW_COMMAND, RawCommand
from sil.wire.dronecan_transfer import Publisher
from tests.target.troubled_fleet import reports
from tests.target.twin_fleets import H_US, Twins, alone, in_formation

OTHER = 99


@pytest.mark.parametrize("indices", [(0, 1), (7, 2), (19, 12), (3, 4)])
def test_escs_with_any_index_act_as_on_single_boats(indices: tuple[int, int]) -> None:
    port, stbd = indices
    twins = Twins()
    twins.diamond()
    twins.boat({"MAV_SYSID": 9, "FORM_LEADER": 100, "ESC_PORT": port, "ESC_STBD": stbd})
    twins.tie(twins.leaders[0], twins.boats[-1])
    twins.enter_formation()
    twins.tick(200)
    assert twins.state(twins.boats[-1]) == "FORMATION" and twins.commands[-1].all()
    twins.compare()


@pytest.mark.parametrize("silence_us", [240_000, 250_000, 250_001, 500_000, 500_001, 3_000_000])
def test_silence_of_commands_has_the_same_effect_as_on_single_boats(silence_us: int) -> None:
    """At the end of a silence the ESC reports before the boat's next command."""
    twins = in_formation()
    reports(twins)
    twins.t_us += silence_us - H_US
    twins.tick()
    assert [esc.power_pct > 0 for esc in reports(twins)] == 2 * [silence_us <= 250_000]
    twins.tick(19)
    twins.compare()


@pytest.mark.parametrize(
    ("silence_us", "power_pct"), [(400_000, 6), (500_000, 0), (600_000, 0), (1_000_000, 0)]
)
def test_silence_of_arming_status_has_the_same_effect_as_on_single_boats(
    silence_us: int, power_pct: int
) -> None:
    twins = in_formation()
    reports(twins)
    twins.t_us += silence_us
    twins.on_bus(Publisher(RAW_COMMAND, 7, OTHER).frames(RawCommand((500, 500)).encode()))
    twins.tick()
    assert [esc.power_pct for esc in reports(twins)] == 2 * [power_pct]
    twins.tick(19)
    twins.compare()


@pytest.mark.parametrize(
    ("length", "commands"), [(0, 0), (1, 0), (2, 1), (7, 4), (35, 20), (36, 0), (70, 0)]
)
def test_commands_of_any_length_have_the_same_effect_as_on_single_boats(
    length: int, commands: int
) -> None:
    """Each command has 14 bits, here 3123 or 38 % of 8191; a message has at most 20 commands."""
    twins = in_formation()
    reports(twins)
    twins.t_us += 4 * H_US  # the ESCs report before the boat's next command
    twins.on_bus(Publisher(RAW_COMMAND, 7, OTHER).frames(b"\x33" * length))
    twins.tick()
    assert [esc.power_pct == 38 for esc in reports(twins)] == [commands > 0, commands > 1]
    twins.tick(4)
    twins.compare()


def test_disarming_has_the_same_effect_as_on_single_boats() -> None:
    twins = in_formation()
    assert twins.commands.all()
    twins.both("command", twins.boats, twins.t_us, 400, (0.0,))
    twins.tick(100)
    assert {twins.state(b) for b in twins.boats} == {"DISARMED"} and not twins.commands.any()
    twins.compare()


def test_any_shaft_speed_is_reported_as_by_single_boats() -> None:
    """Speeds beyond the message's range saturate."""
    twins = alone()
    sensed = twins._sensed
    for rpm in (0.5, 1.5, -0.5, -2.5, 1e4, -1e4, 131071.4, 2e5, -2e5, 1e9):

        def fast(rpm: float = rpm) -> tuple[Any, ...]:
            *rest, shafts = sensed()
            return (*rest, 0 * shafts + rpm)

        twins._sensed = fast
        twins.tick(9)
        told = min(max(round(rpm), -131072), 131071)
        assert {esc.rpm for esc in reports(twins)} == {told}
