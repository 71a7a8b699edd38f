# SPDX-License-Identifier: MIT
"""Judges live runs only if the machine was fast enough for real time."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

MOST_LATE = 0.02  # of the ticks


def sail_punctually(sail: Callable[[int], Path]) -> Path:
    """The folder of a punctual live run, at the second attempt if necessary; else skip the test.

    A boat that is late in more than 2 % of its ticks may rightly stop, as its data are too old.
    `sail` makes attempt 0 or 1 and returns the run's folder.
    """
    told = []
    for attempt in range(2):
        out = sail(attempt)
        late = {
            folder.name: lateness(folder / "stats.json") for folder in sorted(out.glob("boat*"))
        }
        assert late, f"no boat sailed in {out}"
        worst = max(late, key=late.__getitem__)
        if late[worst] <= MOST_LATE:
            return out
        told.append(f"{worst} late in {late[worst]:.0%} of its ticks")
    pytest.skip(f"not judged: this machine is too slow: {', then '.join(told)}")


def lateness(statistics: Path) -> float:
    """The share of a boat's ticks that were late by more than a period, as its file tells."""
    stats = json.loads(statistics.read_text(encoding="utf-8"))
    return float(stats["overruns"] / stats["ticks"])
