# SPDX-License-Identifier: MIT
"""Costs of a fleet: memory per boat, constant over time; profile of its run time."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Any

import flotilla
import numpy as np
import pytest

from sil.bench.bench_fleet import resident_now_kB

ROOT = Path(__file__).parents[2]
LOCAL, EXACT = (100.0, "local", 0.0), (0, 0.0)


def chain(boats: int, radio: dict[str, float] | None = None, **options: Any) -> Any:
    """A leader and boats in a chain, with their links."""
    fleet = flotilla.Fleet(**options)
    fleet.add_leader(0, 255, LOCAL, EXACT)
    for boat in range(1, boats + 1):
        own, ahead = 1 + boat % 250, 1 + (boat - 1) % 250
        fleet.add_boat(0, {"MAV_SYSID": own, "FORM_LEADER": ahead}, LOCAL, EXACT)
        fleet.connect(boat - 1, boat, **radio or {})
        fleet.connect(boat, boat - 1, **radio or {})
    return fleet


def sail(fleet: Any, boats: int, first: int, ticks: int) -> None:
    eta, shafts = np.zeros((boats + 1, 3)), np.zeros((boats, 2))
    for k in range(first, first + ticks):
        fleet.tick(10_000 * k, eta, eta, None, shafts, np.empty((boats, 2)))


def kB_more_of_a_fleet(boats: int) -> float:
    fleet = chain(boats)
    sail(fleet, boats, 0, 3)
    before_kB = resident_now_kB()
    more = chain(4 * boats)
    sail(more, 4 * boats, 0, 3)
    return resident_now_kB() - before_kB


def test_a_boat_with_its_wires_takes_under_44_kB_more() -> None:
    # in a new process, as this one would first reuse freed memory
    what = "from tests.target.test_fleet_costs import *; print(kB_more_of_a_fleet(1000))"
    told = subprocess.check_output([sys.executable, "-c", what], cwd=ROOT, text=True)
    assert 5.0 < float(told) / 4000 < 44.0


@pytest.mark.parametrize("radio", [{}, {"delay_s": 0.05, "jitter_s": 0.05, "loss": 0.1}])
def test_memory_does_not_grow_with_time(radio: dict[str, float]) -> None:
    fleet = chain(100, radio)
    sail(fleet, 100, 0, 500)
    before_kB = resident_now_kB()
    sail(fleet, 100, 500, 1000)
    # One byte per boat and tick would be 100 kB.
    assert resident_now_kB() - before_kB < 80.0


def test_the_profile_says_where_the_time_goes() -> None:
    fleet = chain(20, profile=True)
    sail(fleet, 20, 0, 50)
    spent = fleet.profile()
    assert set(spent) == {"units", "decode", "tick", "can", "links"}
    assert all(seconds > 0 for seconds in spent.values())
    assert set(fleet.profile().values()) == {0.0}


def test_without_a_profile_no_clock_is_read() -> None:
    fleet = chain(2)
    sail(fleet, 2, 0, 5)
    assert set(fleet.profile().values()) == {0.0}
