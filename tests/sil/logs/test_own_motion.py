# SPDX-License-Identifier: MIT
"""The table of a boat's motion and commands: of logs that pymavlink wrote."""

import math
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from sil.logs.own_motion import COLUMNS, of_logs, write

UNIX_US = 1_700_000_000_000_000
BOAT, UNIT = 7, 25
# RawCommand of node 10, by dronecan 1.0.27: [4095, -4096], transfer 1
RAW = ((0.1, "0704060A#FF3C0300C1"),)


def log_of(folder: Path, said: list[tuple[float, int, Any]]) -> None:
    """A tlog of messages (time s, component, message), and a candump log."""
    with (folder / "mavlink0-00001.tlog").open("wb") as file:
        for t_s, component, message in said:
            packed = message.pack(mavlink.MAVLink(None, BOAT, component))
            file.write((UNIX_US + round(1e6 * t_s)).to_bytes(8, "big") + packed)
    lines = [f"({1_700_000_000 + t_s:.6f}) can0 {frame}\n" for t_s, frame in RAW]
    (folder / "can-00001.log").write_text("".join(lines), encoding="ascii")


def odometry(yaw: float, child_frame: int, velocity: tuple[float, float]) -> Any:
    q = (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2))
    ned = mavlink.MAV_FRAME_LOCAL_NED
    zeros = (0.0,) * 21
    speeds = (*velocity, 0.0, 0.0, 0.0, 0.2)
    return mavlink.MAVLink_odometry_message(
        0, ned, child_frame, 1.0, 2.0, 0.0, q, *speeds, zeros, zeros
    )


def test_states_of_the_unit_and_the_last_command_before_each(tmp_path: Path) -> None:
    frd, ned = mavlink.MAV_FRAME_BODY_FRD, mavlink.MAV_FRAME_LOCAL_NED
    own = mavlink.MAVLink_local_position_ned_message(0, 9.0, 9.0, 0.0, 9.0, 9.0, 0.0)
    log_of(
        tmp_path,
        [
            (0.0, UNIT, odometry(math.pi / 2, frd, (0.5, 0.1))),
            (0.05, 1, own),  # what the boat says of itself does not count
            (0.2, UNIT, odometry(math.pi / 2, ned, (-0.1, 0.5))),
        ],
    )
    first, second = of_logs(tmp_path, BOAT)
    assert first == pytest.approx((0.0, 1.0, 2.0, math.pi / 2, 0.5, 0.1, 0.2, 0.0, 0.0))
    motion, commands = second[:7], second[7:]
    assert motion == pytest.approx((0.2, 1.0, 2.0, math.pi / 2, 0.5, 0.1, 0.2))
    assert commands == pytest.approx((4095 / 8191, -4096 / 8191))
    (exchanged,) = list(of_logs(tmp_path, BOAT, port=1, stbd=0))[1:]
    assert exchanged[7:] == pytest.approx((-4096 / 8191, 4095 / 8191))


def test_a_heading_is_carried_to_the_time_of_the_place(tmp_path: Path) -> None:
    attitude = mavlink.MAVLink_attitude_message(1000, 0.0, 0.0, 3.1, 0.0, 0.0, 0.5)
    place = mavlink.MAVLink_local_position_ned_message(1200, 1.0, 2.0, 0.0, -0.5, 0.0, 0.0)
    log_of(tmp_path, [(0.0, UNIT, place), (0.2, UNIT, attitude), (0.3, UNIT, place)])
    (row,) = of_logs(tmp_path, BOAT)
    turned = 3.1 + 0.1 - 2 * math.pi
    assert row.yaw_rad == pytest.approx(turned, abs=1e-6)
    assert row.surge_mps == pytest.approx(-0.5 * math.cos(turned), abs=1e-6)
    assert row.yaw_rate_radps == pytest.approx(0.5)


def test_a_folder_without_both_logs_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no logs of a boat"):
        of_logs(tmp_path, BOAT)


def test_the_file_has_a_line_of_names(tmp_path: Path) -> None:
    path = tmp_path / "motion7.csv"
    assert write(path, []) == 0
    assert path.read_text(encoding="ascii") == COLUMNS + "\n"
