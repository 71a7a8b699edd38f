# SPDX-License-Identifier: MIT
"""States with NaN or impossible values: counted and ignored, so that the state becomes stale."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.target.sea import Sea
from tests.target.stations import state_messages

POSITION = ["x", "y", "z", "vx", "vy", "vz"]
RATES = ["rollspeed", "pitchspeed", "yawspeed"]
FIELDS = [
    *(("ODOMETRY", name) for name in [*POSITION, *RATES, "q0", "q1", "q2", "q3"]),
    *(("LOCAL_POSITION_NED", name) for name in POSITION),
    *(("ATTITUDE", name) for name in ["roll", "pitch", "yaw", *RATES]),
]


def spoil(sea: Sea, agent: str, kind: str, **changes: Any) -> None:
    """Good states, then bad ones only: counted, ignored; the last good one is kept until stale."""
    whose = getattr(sea, agent)
    sea.speak_for(whose, kind)
    assert sea.condition(f"{agent}_fresh") and sea.refused("mavlink") == 0
    good, error = sea.own_course(), sea.snapshot()["error"]
    limit_s = {"own": 0.5, "leader": 1.0}[agent]
    sent, elapsed_s = 0, 0.0
    while elapsed_s < limit_s - 0.12:
        sea.say(*state_messages(kind, whose.course, sea.now_us, **changes), sender=whose.station)
        sent += 1
        sea.run(0.05)
        elapsed_s += 0.05
        assert sea.refused("mavlink") == sent
        assert sea.condition(f"{agent}_fresh")
        assert sea.own_course().close_to(good, 1e-3)
        assert sea.snapshot()["error"] == pytest.approx(error, abs=1e-3)
    for _ in range(12):  # another test checks how soon a missing half makes the state stale
        sea.say(*state_messages(kind, whose.course, sea.now_us, **changes), sender=whose.station)
        sea.run(0.05)
    assert not sea.condition(f"{agent}_fresh")


@pytest.mark.parametrize(("kind", "name"), FIELDS, ids=lambda v: v)
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_state_with_nan_in_a_field_is_ignored(kind: str, name: str, value: float) -> None:
    spoil(Sea(), "own", kind, **{name: value})


@pytest.mark.parametrize(("kind", "name"), FIELDS[::3], ids=lambda v: v)
def test_a_leaders_state_with_nan_in_a_field_is_ignored(kind: str, name: str) -> None:
    spoil(Sea(), "leader", kind, **{name: math.nan})


@pytest.mark.parametrize("agent", ["own", "leader"])
@pytest.mark.parametrize(
    ("kind", "changes"),
    [
        ("ODOMETRY", {"q0": 0.0, "q1": 0.0, "q2": 0.0, "q3": 0.0}),
        ("ODOMETRY", {"q0": 1e-30, "q1": 0.0, "q2": 0.0, "q3": 0.0}),
        ("ODOMETRY", {"q0": 1e30, "q1": 0.0, "q2": 0.0, "q3": 0.0}),
        ("ODOMETRY", {"x": 1e30}),
        ("ODOMETRY", {"vx": -1e30}),
        ("ODOMETRY", {"yawspeed": 1e20}),
        ("LOCAL_POSITION_NED", {"y": 1e30}),
        ("LOCAL_POSITION_NED", {"vy": 1e30}),
        ("ATTITUDE", {"yaw": 1e30}),
        ("ATTITUDE", {"yawspeed": -1e30}),
    ],
    ids=str,
)
def test_a_state_with_an_impossible_value_is_ignored(
    agent: str, kind: str, changes: dict[str, float]
) -> None:
    spoil(Sea(), agent, kind, **changes)
