# SPDX-License-Identifier: MIT
"""The boat's logs, read by common programs: pymavlink and python-can."""

import os
import subprocess
from pathlib import Path

import can
import pytest
from pymavlink import mavutil

ROOT = Path(__file__).parents[3]
START_S = 1700000000.123456


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Ten seconds of a boat, written by tests/linux/logs/write_logs.cpp."""
    build = Path(os.environ.get("FLOTILLA_BUILD", ROOT / "build" / "dev"))
    writer = build / "tests" / "write_logs"
    if not writer.exists():
        pytest.skip(f"{writer} is not built: tools/build dev")
    folder = tmp_path_factory.mktemp("logs")
    subprocess.run([writer, folder], check=True)
    return folder


def messages(path: Path) -> list[mavutil.mavlink.MAVLink_message]:
    log = mavutil.mavlogfile(str(path))
    try:
        return list(iter(log.recv_msg, None))
    finally:
        log.close()


def test_pymavlink_reads_every_packet_of_the_tlog_with_its_time(logs: Path) -> None:
    boat = [m for path in sorted(logs.glob("mavlink0-*.tlog")) for m in messages(path)]
    leader = [m for path in sorted(logs.glob("mavlink1-*.tlog")) for m in messages(path)]
    assert len(list(logs.glob("mavlink0-*.tlog"))) > 1
    assert [m.get_type() for m in boat] == ["HEARTBEAT", "ATTITUDE"] * 100
    assert [m.get_type() for m in leader] == ["LOCAL_POSITION_NED"] * 100
    for i, (heartbeat, attitude, position) in enumerate(
        zip(boat[::2], boat[1::2], leader, strict=True)
    ):
        assert (heartbeat.custom_mode, heartbeat.get_srcSystem()) == (i, 2)
        assert heartbeat.get_seq() == 2 * i
        assert attitude.yaw == pytest.approx(0.01 * i)
        assert (position.x, position.get_srcSystem()) == (1.5, 1)
        assert heartbeat._timestamp == pytest.approx(START_S + 0.1 * i, abs=1e-6)
        # a packet's time is that of its last byte
        assert position._timestamp == pytest.approx(START_S + 0.1 * i + 20e-6, abs=1e-6)


def test_mavlogdumps_entry_point_opens_the_tlog(logs: Path) -> None:
    log = mavutil.mavlink_connection(str(min(logs.glob("mavlink0-*.tlog"))))
    first = log.recv_match(type="HEARTBEAT")
    log.close()
    assert first.type == mavutil.mavlink.MAV_TYPE_SURFACE_BOAT


def test_python_can_reads_every_frame_of_the_candump_log_with_its_time(logs: Path) -> None:
    everything: list[can.Message] = []
    for path in sorted(logs.glob("can-*.log")):
        with can.LogReader(path) as reader:
            everything += list(reader)
    assert len(everything) == 100
    for i, message in enumerate(everything):
        assert message.is_extended_id
        assert (message.arbitration_id, message.channel) == (0x0704060A, "vcan0")
        assert bytes(message.data) == bytes([0xFF, 0x7C, 0x02, 0x00, 0xC0 | i % 32])
        assert message.timestamp == pytest.approx(START_S + 0.1 * i + 30e-6, abs=1e-6)
