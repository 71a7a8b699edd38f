# SPDX-License-Identifier: MIT
"""The log of a real flotillad, as tools/view plays it back."""

from pathlib import Path

import numpy as np

from sil.view.history import numbers
from sil.view.tlog_history import history_of_tlog
from tests.linux.process import RealSea
from tests.target.stations import BOAT, LEADER


def test_a_boats_log_shows_the_boat_its_leader_and_its_way_into_formation(
    sea: RealSea, tmp_path: Path
) -> None:
    sea.start(f"--log={tmp_path / 'log'}")
    sea.enter_formation()
    sea.run(2.5)
    assert sea.end() == 0
    (tlog,) = (tmp_path / "log").glob("*.tlog")
    history = history_of_tlog(tlog)
    vessels = {vessel["id"]: vessel for vessel in history["vessels"]}
    assert set(vessels) == {BOAT, LEADER}
    boat, leader = vessels[BOAT], vessels[LEADER]
    assert (boat["kind"], boat["leader"], leader["kind"]) == ("boat", LEADER, "leader")
    states = [state for _, state in boat["states"]]
    assert states[0] == "DISARMED" and "FORMATION" in states
    told = [m for m in sea.named("LOCAL_POSITION_NED") if m.get_srcSystem() == BOAT]
    shown = ~np.isnan(numbers(boat["x_m"]))
    assert shown.sum() > 10
    assert abs(numbers(boat["x_m"])[shown][-1] - told[-1].x) < 0.5
    assert numbers(boat["battery_V"])[-1] == 24.0
    assert np.nanmax(np.abs(numbers(boat["thrust_port_N"]))) > 0.0
