# SPDX-License-Identifier: MIT
"""The live SIL on the kernel's CAN: four flotillads, four buses, real time."""

import json
from pathlib import Path

import numpy as np
import pytest

from sil.cli.main import main
from sil.live.live_world import FLOTILLAD
from sil.lockstep import metrics
from tests.punctual import sail_punctually

DURATION_S = 40


def distances_m(out: Path) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
    """|e| of each boat at the last tick."""
    with np.load(out / "trace.npz") as trace:
        return np.asarray(metrics.distances(trace["error"])[-1])


def test_boats_on_vcan_are_where_the_lockstep_has_them(tmp_path: Path) -> None:
    if not FLOTILLAD.exists():
        pytest.skip(f"needs {FLOTILLAD}: tools/build release flotillad")

    def sail(out: Path) -> None:
        live = ["live", "diamond", "--bus", "socketcan:vcan0", "--duration", str(DURATION_S)]
        assert main([*live, "--out", str(out)]) == 0

    live, lockstep = sail_punctually(sail, tmp_path), tmp_path / "lockstep"
    length = ["--set", f"duration_s={DURATION_S}"]
    assert main(["run", "diamond", *length, "--out", str(lockstep)]) == 0
    expected_m = distances_m(lockstep)
    difference_m = np.abs(distances_m(live) - expected_m)
    assert (difference_m < 0.05 + 0.1 * expected_m).all(), difference_m
    summary = json.loads((live / "summary.json").read_text(encoding="utf-8"))
    assert [boat["states"].keys() for boat in summary["boats"]] == [{"FORMATION"}] * 4
    for boat in range(1, 5):
        stats = json.loads((live / f"boat{boat}" / "stats.json").read_text(encoding="utf-8"))
        assert stats["ticks"] > 95 * DURATION_S
        assert stats["can"]["transfers_dropped"] == stats["can"]["receive_overflows"] == 0
