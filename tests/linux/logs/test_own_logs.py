# SPDX-License-Identifier: MIT
"""flotillad's own logs of a real boat, read by common programs: pymavlink and python-can."""

import itertools
import time
from pathlib import Path

import can
import pytest
from pymavlink import mavutil

from tests.linux.logs.test_logs import messages
from tests.linux.process import RealSea, Udp
from tests.target.bus import NODE
from tests.target.stations import (
    BOAT,
    GCS,
    GCS_COMPONENT,
    LEADER,
    LEADER_COMPONENT,
    NAVIGATION,
)


def test_flotillads_own_logs_have_both_directions(sea: RealSea, tmp_path: Path) -> None:
    sea.start(f"--log={tmp_path / 'log'}")
    sea.enter_formation()
    assert sea.end() == 0
    (tlog,), (candump,) = ((tmp_path / "log").glob(kind) for kind in ("*.tlog", "*.log"))

    log = mavutil.mavlink_connection(str(tlog))
    everything = list(iter(log.recv_msg, None))
    log.close()
    assert not any(m.get_type() == "BAD_DATA" for m in everything)
    said = {(m.get_srcSystem(), m.get_srcComponent(), m.get_type()) for m in everything}
    assert {
        (BOAT, 1, "HEARTBEAT"),
        (BOAT, 1, "COMMAND_ACK"),
        (BOAT, 1, "ATTITUDE"),
        (BOAT, NAVIGATION, "ODOMETRY"),
        (LEADER, LEADER_COMPONENT, "ODOMETRY"),
        (GCS, GCS_COMPONENT, "COMMAND_LONG"),
    } <= said

    with can.LogReader(candump) as reader:
        assert isinstance(reader, can.CanutilsLogReader)
        frames = list(reader)
    assert {frame.channel for frame in frames} == {f"mcast{sea.bus}"}
    logged = [(frame.arbitration_id, bytes(frame.data)) for frame in frames]
    sent = [frame for frame in logged if frame[0] & 0x7F == NODE]
    assert sent[-len(sea.heard) :] == sea.frames()
    assert {31, 32} <= {can_id & 0x7F for can_id, _ in logged}
    times = [frame.timestamp for frame in frames]
    assert times == sorted(times)
    assert times[-1] == pytest.approx(time.time(), abs=60.0)


def test_no_packet_is_missing_or_twice_in_the_log_of_a_link(sea: RealSea, tmp_path: Path) -> None:
    sea.connect(Udp(), Udp())
    sea.start(f"--log={tmp_path / 'log'}")
    sea.enter_formation()
    sea.until(lambda: all(len(sea.named("HEARTBEAT", link)) > 4 for link in (0, 1)))
    assert sea.end() == 0
    tlogs = sorted((tmp_path / "log").glob("*.tlog"))
    assert [path.name for path in tlogs] == ["mavlink0-00001.tlog", "mavlink1-00001.tlog"]
    for path in tlogs:
        said = [m.get_msgbuf() for m in messages(path)]  # stock pymavlink: some are unknown to it
        numbers = [raw[4] for raw in said if (raw[5], raw[6]) == (BOAT, 1)]
        assert len(numbers) > 50
        assert {(b - a) % 256 for a, b in itertools.pairwise(numbers)} == {1}
