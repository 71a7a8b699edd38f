# SPDX-License-Identifier: MIT
"""The live SIL on the kernel's CAN, real time: two flotillads, nightly four, a bus each."""

import json
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from sil.lockstep import metrics
from sil.lockstep.world import Run
from sil.lockstep.world import sail as sail_in_lockstep
from sil.report import one_run
from sil.scenario import scenario
from tests.flotillad import needs_flotillad
from tests.punctual import sail_punctually


@pytest.mark.parametrize(
    ("boats", "duration_s"), [(2, 15), pytest.param(4, 40, marks=pytest.mark.nightly)]
)
def test_boats_on_vcan_are_where_the_lockstep_has_them(
    boats: int, duration_s: int, tmp_path: Path
) -> None:
    needs_flotillad()
    diamond = scenario.load("diamond", [f"duration_s={duration_s}"])
    fleet = diamond.model_copy(update={"boat": diamond.boat[:boats]})

    def sail(out: Path) -> None:
        one_run.live(fleet, "socketcan:vcan0", out, {}, "", Console(quiet=True))

    live = sail_punctually(sail, tmp_path)
    (lockstep,) = sail_in_lockstep([fleet], {})
    assert isinstance(lockstep, Run)
    expected_m = metrics.distances(lockstep.trace["error"])[-1]
    with np.load(live / "trace.npz") as trace:
        difference_m = np.abs(metrics.distances(trace["error"])[-1] - expected_m)
    assert (difference_m < 0.05 + 0.1 * expected_m).all(), difference_m
    summary = json.loads((live / "summary.json").read_text(encoding="utf-8"))
    assert [boat["states"].keys() for boat in summary["boats"]] == [{"FORMATION"}] * boats
    for boat in range(1, boats + 1):
        stats = json.loads((live / f"boat{boat}" / "stats.json").read_text(encoding="utf-8"))
        assert stats["ticks"] > 95 * duration_s
        assert stats["can"]["transfers_dropped"] == stats["can"]["receive_overflows"] == 0
