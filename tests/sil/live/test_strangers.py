# SPDX-License-Identifier: MIT
"""A boat whose links strangers flood and tear, beside one that is left alone: bench --flood."""

from pathlib import Path

from rich.progress import Progress

from sil.bench import bench
from tests.flotillad import needs_flotillad
from tests.live_buses import live_buses


def test_a_flooded_boat_computes_as_many_ticks_as_the_one_beside_it(tmp_path: Path) -> None:
    needs_flotillad()
    with live_buses() as bus, Progress(disable=True) as progress:
        found = bench.measure_flooded(bus, 4.0, tmp_path, progress)
    assert found["datagrams_per_s"] > 2_000
    ticks = [found[name]["ticks"] for name in ("flooded", "calm")]
    assert min(ticks) > 400 and abs(ticks[0] - ticks[1]) < 100
