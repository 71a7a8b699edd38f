# SPDX-License-Identifier: MIT
"""The boat's heartbeat: vehicle, mode and status, in time."""

from __future__ import annotations

import numpy as np

from tests.target.sea import Sea
from tests.target.stations import ARMED_BIT, FORMATION, HOLD

STANDBY, ACTIVE, CRITICAL, EMERGENCY = 3, 4, 5, 6
CUSTOM, AUTO, GUIDED = 1, 4, 8


def test_the_heartbeat_tells_vehicle_mode_and_status(voyage: Sea) -> None:
    expected = {
        "DISARMED": (CUSTOM, HOLD, STANDBY),
        "HOLD": (CUSTOM | ARMED_BIT, HOLD, ACTIVE),
        "FORMATION": (CUSTOM | ARMED_BIT | AUTO | GUIDED, FORMATION, ACTIVE),
        "COAST": (CUSTOM | ARMED_BIT | AUTO | GUIDED, FORMATION, CRITICAL),
        "FAULT": (CUSTOM, HOLD, EMERGENCY),
    }
    seen, state = set(), "DISARMED"
    for tick in voyage.ticks:
        for said in tick.named("STATUSTEXT"):
            if said.text.split(":")[0] in expected:
                state = said.text.split(":")[0]
        for m in tick.named("HEARTBEAT"):
            assert (m.type, m.autopilot, m.mavlink_version) == (11, 0, 3)
            assert (m.base_mode, m.custom_mode, m.system_status) == expected[state]
            seen.add(state)
    assert seen == set(expected)


def test_the_heartbeat_comes_every_second_whatever_happens(voyage: Sea) -> None:
    times = [tick.now_us for tick in voyage.ticks if tick.named("HEARTBEAT")]
    assert max(np.diff(times)) <= 1_000_000
    assert len(times) < (times[-1] - times[0]) / 1e6 + 100  # and not at each tick


def test_a_heartbeat_follows_every_change_of_state_at_once(sea: Sea) -> None:
    sea.settle()
    assert sea.arm().named("HEARTBEAT")[-1].base_mode & ARMED_BIT
    assert sea.mode(FORMATION).named("HEARTBEAT")[-1].custom_mode == FORMATION
    assert sea.mode(HOLD).named("HEARTBEAT")[-1].custom_mode == HOLD
    assert not sea.disarm().named("HEARTBEAT")[-1].base_mode & ARMED_BIT
