# SPDX-License-Identifier: MIT
"""A real flotillad's logs as MCAP: equal to what pymavlink, mavlogdump and python-can read."""

import subprocess
import sys
from pathlib import Path
from typing import Any

import can
import pytest
from pymavlink import mavutil

from sil.cli.main import main
from tests.linux.process import RealSea
from tests.sil.logs.reading import assert_schemas_are_by_topic, messages_of
from tests.target.bus import ESC_STATUS, type_of
from tests.target.stations import BOAT, LEADER

Topics = dict[str, list[tuple[int, Any]]]


def test_converted_logs_agree_with_other_readers(sea: RealSea, tmp_path: Path) -> None:
    folder = tmp_path / "log"
    sea.start(f"--log={folder}")
    sea.enter_formation()
    sea.run(2.0)
    assert sea.end() == 0
    (tlog,), (candump,) = folder.glob("*.tlog"), folder.glob("*.log")
    out = tmp_path / "boat.mcap"
    assert main(["convert", str(folder), "--out", str(out)]) == 0
    assert_schemas_are_by_topic(out)
    topics = messages_of(out)
    positions_are_pymavlinks(topics, tlog)
    escs_are_python_cans(topics, candump)
    changes = [line.message for _, line in topics[f"/boat{BOAT}/log"] if "→" in line.message]
    assert changes[:2] == ["DISARMED → HOLD", "HOLD → FORMATION"]
    assert {f"/boat{BOAT}/law", f"/boat{BOAT}/fix", f"/leader{LEADER}/state"} <= set(topics)

    mavlogdump = Path(sys.executable).parent / "mavlogdump.py"
    command = [sys.executable, str(mavlogdump), "--types", "LOCAL_POSITION_NED", str(tlog)]
    dumped = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert dumped.count("LOCAL_POSITION_NED") >= len(topics[f"/boat{BOAT}/state"]) > 10


def positions_are_pymavlinks(topics: Topics, tlog: Path) -> None:
    log = mavutil.mavlogfile(str(tlog))
    said: dict[int, Any] = {}
    while message := log.recv_match(type="LOCAL_POSITION_NED"):
        if (message.get_srcSystem(), message.get_srcComponent()) == (BOAT, 1):
            said.setdefault(message.time_boot_ms, message)
    log.close()
    states = topics[f"/boat{BOAT}/state"]
    assert len(states) == len(said) > 0
    for (t_ns, state), message in zip(states, said.values(), strict=True):
        assert t_ns * 1e-9 == pytest.approx(message._timestamp, abs=1e-6)
        assert (state.x_m, state.y_m) == (message.x, message.y)
        speed = (state.u_mps**2 + state.v_mps**2) ** 0.5
        assert speed == pytest.approx((message.vx**2 + message.vy**2) ** 0.5)


def escs_are_python_cans(topics: Topics, candump: Path) -> None:
    with can.LogReader(candump) as reader:
        frames = list(reader)
    for index, node in enumerate((31, 32)):
        ends = [
            frame.timestamp
            for frame in frames
            if frame.arbitration_id & 0x7F == node
            and type_of(frame.arbitration_id)[:2] == (False, ESC_STATUS)
            and frame.data[-1] & 0x40
        ]
        escs = topics[f"/boat{BOAT}/esc/{index}"]
        assert [t_ns * 1e-9 for t_ns, _ in escs] == pytest.approx(ends, abs=1e-6)
        assert {esc.voltage_V for _, esc in escs} == {24.0}
