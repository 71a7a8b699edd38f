# SPDX-License-Identifier: MIT
"""Whether a machine had the time for boats that sail in real time."""

import json
from pathlib import Path

import pytest

_MOST_LATE = 0.02  # of the ticks


def skip_where_too_slow(out: Path) -> None:
    """Skip the test if a boat of the live run in `out` came late to more than 2 % of its ticks.

    It may then have stopped, rightly: what it was told was too old.
    """
    for folder in sorted(out.glob("boat*")):
        stats = json.loads((folder / "stats.json").read_text(encoding="utf-8"))
        share = stats["overruns"] / stats["ticks"]
        if share > _MOST_LATE:
            pytest.skip(f"this machine is too slow: {folder.name} was late in {share:.0%} of ticks")
