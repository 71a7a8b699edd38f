# SPDX-License-Identifier: MIT
"""Judges live runs only if the machine was fast enough for real time."""

import json
from collections.abc import Callable
from pathlib import Path

import pytest

from sil.lockstep.start import RunError

MOST_LATE = 0.02  # of the ticks
WORLD_LATE_S = 0.3  # the run itself then says that the machine is too slow; boats stop at 0.5 s


def sail_punctually(sail: Callable[[Path], None], parent: Path) -> Path:
    """The folder in `parent` of a punctual live run, at the second attempt if necessary.

    A boat that is late in more than 2 % of its ticks, or gets its data late from the simulation,
    may rightly stop, or not start. So an assertion that fails in `sail`, which makes one run in the
    folder that it gets, or a run that ends early, counts only if all were punctual. If they were
    late twice, the test is skipped.
    """
    told = []
    for attempt in range(2):
        out, failure = parent / str(attempt), None
        try:
            sail(out)
        except (AssertionError, RunError) as error:
            failure = error
        late = {file.parent.name: lateness(file) for file in sorted(out.glob("boat*/stats.json"))}
        worst = max(late, key=late.__getitem__, default="")
        if late and late[worst] > MOST_LATE:
            told.append(f"{worst} late in {late[worst]:.0%} of its ticks")
            continue
        if failure is not None and (world_s := world_late_s(out)) > WORLD_LATE_S:
            told.append(f"the simulation {world_s:.2f} s late")
            continue
        if failure is not None:
            raise failure
        assert late, f"no boat sailed in {out}"
        return out
    pytest.skip(f"not judged: this machine is too slow: {', then '.join(told)}")


def lateness(statistics: Path) -> float:
    """The share of a boat's ticks that were late by more than a period, as its file tells."""
    stats = json.loads(statistics.read_text(encoding="utf-8"))
    return float(stats["overruns"] / stats["ticks"])


def world_late_s(out: Path) -> float:
    """By how much the simulation was late at its worst tick, as the run's summary tells."""
    summary = out / "summary.json"
    if not summary.exists():
        return 0.0
    return float(json.loads(summary.read_text(encoding="utf-8"))["late_s"] or 0.0)
