# SPDX-License-Identifier: MIT
"""Faults of processes, buses and disks, and the response of a flotillad on vcan0."""

import pytest

from sil.faults import live_matrix
from sil.faults.fault_outcome import Outcome
from sil.faults.live_strikes import STRIKES
from tests.flotillad import needs_flotillad

NAMES = [row.name for row in live_matrix.limits()]


@pytest.fixture(scope="module")
def outcomes() -> dict[str, Outcome]:
    """All faults with one boat, one after another.

    The machine may be late, so a fault that fails counts as taken if it passes twice after that.
    """
    needs_flotillad()
    first = {one.fault: one for one in live_matrix.sail()}
    if all(one.passed for one in first.values()):
        return first
    failed = {name for name, one in first.items() if not one.passed}
    print("sailed again:", *(first[name] for name in failed), sep="\n")
    for _ in range(2):
        again = {one.fault: one for one in live_matrix.sail()}
        if any(not again[name].passed for name in failed):
            break
    return {name: again[name] if name in failed else one for name, one in first.items()}


@pytest.mark.parametrize("name", NAMES)
def test_every_live_fault_stays_within_its_limits(outcomes: dict[str, Outcome], name: str) -> None:
    assert outcomes[name].passed, outcomes[name]


def test_every_strike_has_limits() -> None:
    assert list(STRIKES) == NAMES


@pytest.mark.parametrize(
    ("seen", "why"),
    [
        ((0.1, "HOLD", 0.0, 1.0), ""),
        ((None, "HOLD", 0.0, 1.0), "noticed after –"),
        ((2.0, "HOLD", 0.0, 1.0), "noticed after 2.00 s"),
        ((0.1, "FORMATION", 0.0, 1.0), "FORMATION, not HOLD"),
        ((0.1, "HOLD", 0.3, 1.0), "0.30 N told where none was wanted"),
        ((0.1, "HOLD", 0.0, None), "back after –"),
        ((0.1, "HOLD", 0.0, 60.0), "back after 60.00 s"),
    ],
)
def test_an_outcome_beyond_a_limit_fails(
    seen: tuple[float | None, str, float, float | None], why: str
) -> None:
    row = next(row for row in live_matrix.limits() if row.name == "stopped")
    said = live_matrix.beyond(row, *seen)
    assert [why in each for each in said] == ([True] if why else [])
