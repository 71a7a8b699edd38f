# SPDX-License-Identifier: MIT
"""A boat whose links strangers flood and tear, beside one that is left alone: bench --flood."""

from pathlib import Path

from rich.progress import Progress

from sil.bench import bench
from tests.flotillad import needs_flotillad
from tests.live_buses import live_buses


def test_a_flooded_boat_computes_most_of_the_ticks_of_the_one_beside_it(tmp_path: Path) -> None:
    needs_flotillad()
    with live_buses() as bus, Progress(disable=True) as progress:
        found = bench.measure_flooded(bus, 4.0, tmp_path, progress)
    # On a busy machine the flood takes ticks from the boat; unlimited reading would leave none.
    assert found["datagrams_per_s"] > 1_000
    flooded, calm = (found[name]["ticks"] for name in ("flooded", "calm"))
    assert flooded > max(0.6 * calm, 240), found
