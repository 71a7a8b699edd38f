# SPDX-License-Identifier: MIT
"""Boats that keep their slots behind a resting leader, in a current."""

import pytest

from sil.faults.rows import FOLDER
from sil.lockstep.world import sail
from sil.scenario import scenario


@pytest.mark.parametrize("stream_mps", [[-0.7, 0.0], [0.4, 0.0], [0.0, 0.5]])
def test_boats_at_rest_in_a_stream_stay_in_formation(
    stream_mps: list[float],
) -> None:
    still = ["duration_s=20.0", "leader.nu=[0.0, 0.0, 0.0]", "leader.input=[]"]
    source = scenario.read(FOLDER / "pair.toml", [*still, f"water.current_mps={stream_mps}"])
    for boat in source.document["boat"]:
        boat["nu"] = [0.0, 0.0, 0.0]
    (run,) = sail([scenario.check(source)], {})
    assert [list(states) for states in run.states] == [["FORMATION"], ["FORMATION"]]
