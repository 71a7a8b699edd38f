# SPDX-License-Identifier: MIT
"""Boats' logs converted to MCAP have the boats' messages; damage is counted and skipped."""

import math
import re
import shutil
import struct
import subprocess
import sys
from pathlib import Path
from typing import Any

import can
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from sil.cli.main import main
from sil.logs import boats
from sil.wire.dronecan import ESC_STATUS, EscStatus
from sil.wire.dronecan_transfer import Publisher
from sil.wire.geodesy import LocalFrame
from tests.dialect import dialect
from tests.sil.logs.reading import assert_schemas_are_by_topic, messages_of
from tests.sil.mistakes import assert_told_in_one_line
from tests.turns import some

START_US = 1_700_000_000_123_456
ORIGIN = (473_977_420, 85_455_940, 488_000)
SECOND_US = 1_000_000
STEPS = 50
NONE, EAST, UNKNOWN = (0, 0, 0), (0.5**0.5, 0, 0, 0.5**0.5), [math.nan] * 21


class Pen:
    """Writes a tlog by pymavlink."""

    def __init__(self) -> None:
        self.content = b""
        self._encoders: dict[tuple[int, int], Any] = {}

    def put(self, t_us: int, system: int, component: int, *messages: Any) -> None:
        key = (system, component)
        encoder = self._encoders.setdefault(key, dialect().MAVLink(None, *key))
        for message in messages:
            self.content += struct.pack(">Q", t_us) + bytes(message.pack(encoder))


def north_m(step: int) -> float:
    return 0.5 * step


def write_boat(path: Path, boat: int = 2, leader: int = 1, offset_us: int = 0) -> None:
    """Write 5 s at 10 Hz of a boat and its leader, whose frame has another origin."""
    pen = Pen()
    elsewhere = LocalFrame(*ORIGIN[:2], 488.0).moved(100.0, 50.0).origin_degE7
    d = dialect()
    for step in range(STEPS):
        t_us, ms = START_US + offset_us + 100_000 * step, 100 * step
        if step % 10 == 0:
            mode, status = (4, 4) if step < 20 else (6, 4 if step < 40 else 5)
            beat = d.MAVLink_heartbeat_message(11, 0, 0x81, mode, status, 3)
            origin = d.MAVLink_gps_global_origin_message(*ORIGIN, 0)
            pen.put(t_us, boat, 1, beat, origin)
            virtual = (0, 8, 0, 0, 4, 3)
            beat = d.MAVLink_heartbeat_message(*(virtual if leader == 1 else (11, 0, 0, 0, 3, 3)))
            origin = d.MAVLink_gps_global_origin_message(*elsewhere, 488_000, 0)
            pen.put(t_us, leader, 1, beat, origin)
            named = [("E_X", 3.0), ("E_Y", -4.0), ("LEAD_AGE", 0.05), ("T_PORT", 1.5)]
            for name, value in named:
                said = d.MAVLink_named_value_float_message(ms, name.encode(), value)
                pen.put(t_us, boat, 1, said, said)  # over two links
        pen.put(t_us, boat, 220, d.MAVLink_local_position_ned_message(ms, 9, 9, 0, 9, 9, 0))
        turn = d.MAVLink_attitude_message(ms, 0, 0, 0.5 * math.pi, 0, 0, 0.1)
        place = d.MAVLink_local_position_ned_message(ms, north_m(step), 2.0, 0, 0.0, 5.0, 0)
        pen.put(t_us, boat, 1, turn, place)
        pen.put(t_us + 5, boat, 1, turn, place)
        pen.put(t_us + 9, leader, 1, turn, place)
    text = b"PreArm: own state is stale, and so is the leader's, wait"
    for number, chunk in enumerate((text[:50], text[50:])):
        said = d.MAVLink_statustext_message(4, chunk, id=7, chunk_seq=number)
        pen.put(START_US + offset_us + 5 * SECOND_US, boat, 1, said)
    path.write_bytes(pen.content)


def write_candump(path: Path, bus: str = "vcan0") -> None:
    """Write the two ESCs' status at 10 Hz."""
    publishers = [Publisher(ESC_STATUS, 16, 31 + index) for index in (0, 1)]
    with can.CanutilsLogWriter(path) as writer:
        for step in range(STEPS):
            for index, publisher in enumerate(publishers):
                status = EscStatus(step, 24.0, 2.5, 300.0, -100 * step, 20, index)
                for can_id, data in publisher.frames(status.encode()):
                    t_s = 1e-6 * (START_US + 100_000 * step)
                    frame = can.Message(t_s, can_id, data=data, channel=bus)
                    writer.on_message_received(frame)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    """A boat's folder of logs."""
    folder = tmp_path / "log"
    folder.mkdir()
    write_boat(folder / "mavlink0-00001.tlog")
    return folder


def converted(*arguments: Path | str) -> dict[str, list[tuple[int, Any]]]:
    out = Path(arguments[-1])
    assert main(["convert", *map(str, arguments[:-1]), "--out", str(out)]) == 0
    assert_schemas_are_by_topic(out)
    return messages_of(out)


def test_a_boat_is_at_the_position_that_it_reported(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "[out].mcap"
    topics = converted(log, out)
    told = capsys.readouterr().out
    assert f"{out}: " in told and "messages of boat2, leader1" in told
    states, fixes = topics["/boat2/state"], topics["/boat2/fix"]
    assert len(states) == len(fixes) == STEPS
    world = LocalFrame(*ORIGIN[:2], 488.0)
    for step, ((t_ns, state), (_, fix)) in enumerate(zip(states, fixes, strict=True)):
        assert t_ns == 1000 * (START_US + 100_000 * step)
        assert (state.x_m, state.y_m) == (north_m(step), 2.0)
        assert state.psi_rad == pytest.approx(0.5 * math.pi)
        assert (state.u_mps, state.v_mps, state.r_radps) == pytest.approx((5.0, 0.0, 0.1), abs=1e-6)
        latitude, longitude, _ = world.geodetic(north_m(step), 2.0, 0.0)
        assert (fix.latitude, fix.longitude) == pytest.approx((1e-7 * latitude, 1e-7 * longitude))


def test_a_vessel_with_another_origin_is_in_the_frame_of_the_first(
    log: Path, tmp_path: Path
) -> None:
    states = converted(log, tmp_path / "out.mcap")["/leader1/state"]
    for step, (_, state) in enumerate(some(states)):
        assert (state.x_m, state.y_m) == pytest.approx((100.0 + north_m(step), 52.0), abs=0.02)


def test_an_unwritable_folder_is_reported_before_the_conversion(
    log: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(boats, "convert", lambda *_: pytest.fail("converted in vain"))
    assert main(["convert", str(log), "--out", "/proc/out.mcap"]) == 2
    assert_told_in_one_line("/proc/out.mcap: ", capsys)


def test_a_message_sent_over_two_links_is_logged_once(log: Path, tmp_path: Path) -> None:
    laws = converted(log, tmp_path / "out.mcap")["/boat2/law"]
    assert len(laws) == 5
    for _, law in laws:
        assert (law.error_x_m, law.error_y_m, law.error_m) == (3.0, -4.0, 5.0)
        assert law.leader_age_s == pytest.approx(0.05)
        assert law.thrust_port_N == 1.5
        assert math.isnan(law.wanted_u_mps)


def test_states_and_long_sentences_are_in_the_log(log: Path, tmp_path: Path) -> None:
    topics = converted(log, tmp_path / "out.mcap")
    lines = [(line.level, line.message) for _, line in topics["/boat2/log"]]
    levels = topics["/boat2/log"][0][1]
    assert lines == [
        (levels.INFO, "HOLD"),
        (levels.INFO, "HOLD → FORMATION"),
        (levels.WARNING, "FORMATION → COAST"),
        (levels.WARNING, "PreArm: own state is stale, and so is the leader's, wait"),
    ]
    states = [status.state for _, status in topics["/boat2/status"]]
    assert states == ["HOLD", "HOLD", "FORMATION", "FORMATION", "COAST"]


def test_a_candump_log_is_of_the_boat_beside_whose_tlog_it_lies(log: Path, tmp_path: Path) -> None:
    write_candump(log / "can-00001.log")
    topics = converted(log, tmp_path / "out.mcap")
    escs = topics["/boat2/esc/1"]
    assert len(escs) == STEPS
    for step, (t_ns, esc) in enumerate(escs):
        assert t_ns == 1000 * (START_US + 100_000 * step)
        assert (esc.rpm, esc.voltage_V, esc.current_A) == (-100.0 * step, 24.0, 2.5)
        assert (esc.errors, esc.power_percent) == (step, 20)
        assert esc.temperature_degC == pytest.approx(300.0 - 273.15, abs=0.2)


def test_a_candump_log_alone_is_named_after_its_bus(tmp_path: Path) -> None:
    write_candump(tmp_path / "can.log", "can3")
    topics = converted(tmp_path / "can.log", tmp_path / "out.mcap")
    assert set(topics) == {"/can3/esc/0", "/can3/esc/1"}


def test_without_a_candump_log_escs_are_read_from_the_boats_telemetry(tmp_path: Path) -> None:
    d, pen = dialect(), Pen()
    beat = d.MAVLink_heartbeat_message(11, 0, 0x81, 4, 4, 3)
    none = [0, 0]
    info = d.MAVLink_esc_info_message(
        0, 0, 0, 2, 5, 3, [0] * 4, [7, 8, *none], [4250, 32767, *[32767] * 2]
    )
    status = d.MAVLink_esc_status_message(
        0, 0, [900, -300, *none], [24.5, 24.25, *none], [1.5, 0.5, *none]
    )
    pen.put(START_US, 3, 1, beat, info, status)
    (tmp_path / "boat.tlog").write_bytes(pen.content)
    topics = converted(tmp_path / "boat.tlog", tmp_path / "out.mcap")
    ((_, port),), ((_, stbd),) = topics["/boat3/esc/0"], topics["/boat3/esc/1"]
    assert "/boat3/esc/2" not in topics
    assert (port.rpm, port.voltage_V, port.current_A, port.errors) == (900, 24.5, 1.5, 7)
    assert port.temperature_degC == pytest.approx(42.5)
    assert (stbd.rpm, stbd.voltage_V, stbd.current_A, stbd.errors) == (-300, 24.25, 0.5, 8)
    assert math.isnan(stbd.temperature_degC)


def test_several_boats_logs_become_one_file_with_each_boats_own_messages(tmp_path: Path) -> None:
    folders = [tmp_path / "two", tmp_path / "three"]
    for folder, boat in zip(folders, (2, 3), strict=True):
        folder.mkdir()
        # boat 3 hears boat 2, its leader; its clock is a second ahead
        write_boat(folder / "mavlink0-00001.tlog", boat, boat - 1, (boat - 2) * SECOND_US)
        write_candump(folder / "can-00001.log")
        # a second link with the same messages, where its unit is heard too
        shutil.copy(folder / "mavlink0-00001.tlog", folder / "mavlink1-00001.tlog")
    topics = converted(*folders, tmp_path / "out.mcap")
    for boat in (2, 3):
        begin_ns = 1000 * (START_US + (boat - 2) * SECOND_US)
        times = [t_ns for t_ns, _ in topics[f"/boat{boat}/state"]]
        assert times == [begin_ns + 100_000_000 * step for step in range(STEPS)]
        assert len(topics[f"/boat{boat}/esc/0"]) == STEPS
    assert len(topics["/leader1/state"]) == STEPS


@pytest.mark.parametrize(
    ("message", "place"),
    [
        ("global_position_int", (0, *ORIGIN[:2], 488_000, 0, 0, 300, 0, 65535)),
        ("follow_target", (0, 15, *ORIGIN[:2], 488.0, (0, 3, 0), NONE, EAST, NONE, NONE, 0)),
        ("odometry", (0, 1, 12, 0, 0, 0, EAST, 3, 0, 0, 0, 0, 0, UNKNOWN, UNKNOWN)),
    ],
)
def test_a_boat_that_sends_other_messages_is_at_the_same_place(
    message: str, place: tuple[Any, ...], tmp_path: Path
) -> None:
    d, pen = dialect(), Pen()
    pen.put(START_US, 4, 1, d.MAVLink_gps_global_origin_message(*ORIGIN, 0))
    pen.put(START_US, 4, 1, d.MAVLink_attitude_message(0, 0, 0, 0.5 * math.pi, 0, 0, 0))
    pen.put(START_US, 4, 1, getattr(d, f"MAVLink_{message}_message")(*place))
    (tmp_path / "boat.tlog").write_bytes(pen.content)
    ((_, state),) = converted(tmp_path / "boat.tlog", tmp_path / "out.mcap")["/boat4/state"]
    assert (state.x_m, state.y_m) == pytest.approx((0.0, 0.0), abs=0.01)
    assert state.psi_rad == pytest.approx(0.5 * math.pi)
    assert (state.u_mps, state.v_mps) == pytest.approx((3.0, 0.0), abs=1e-6)


def test_damaged_bytes_of_a_tlog_are_left_out_and_counted(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = log / "mavlink0-00001.tlog"
    content = bytearray(path.read_bytes())
    middle = len(content) // 2
    content[middle : middle + 40] = b"\xfd" * 40
    path.write_bytes(content[:-3])
    topics = converted(log, tmp_path / "out.mcap")
    told = re.search(r"skipped (\d+) damaged bytes of the logs", capsys.readouterr().out)
    assert told and 40 < int(told[1]) < 400
    assert STEPS - 3 <= len(topics["/boat2/state"]) <= STEPS
    assert {state.x_m for _, state in topics["/boat2/state"]} <= {north_m(s) for s in range(STEPS)}


def test_a_candump_log_that_is_cut_off_loses_its_last_line_only(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_candump(log / "can-00001.log")
    whole = (log / "can-00001.log").read_bytes()
    (log / "can-00001.log").write_bytes(whole[:-4])
    topics = converted(log, tmp_path / "out.mcap")
    assert len(topics["/boat2/esc/0"]) == STEPS
    assert len(topics["/boat2/esc/1"]) == STEPS - 1
    assert "damaged" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("empty.tlog", b"", "empty.tlog: the file is empty"),
        ("empty.log", b"", "empty.log: the file is empty"),
        ("noise.tlog", bytes(range(256)) * 40, "contains no MAVLink packet"),
        ("noise.log", b"(yesterday) can0\n" * 9, "contains no CAN frame"),
        ("missing.tlog", None, "missing.tlog: No such file"),
        ("folder/readme.txt", b"nothing", "neither the folder of a run nor one with logs"),
    ],
)
def test_a_file_that_is_not_a_log_is_reported_in_one_line_and_nothing_is_written(
    name: str, content: bytes | None, said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / name
    if content is not None:
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)
    given = path.parent if "folder" in name else path
    assert main(["convert", str(given), "--out", str(tmp_path / "out.mcap")]) == 2
    assert_told_in_one_line(said, capsys)
    assert not any(".mcap" in path.name for path in tmp_path.iterdir())


def test_a_missing_folder_is_reported(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["convert", str(log), "--out", str(tmp_path / "nowhere" / "out.mcap")]) == 2
    assert_told_in_one_line("nowhere: no such folder", capsys)


def test_the_log_folder_of_a_live_boat_is_converted(log: Path, tmp_path: Path) -> None:
    assert main(["convert", str(log.parent), "--out", str(tmp_path / "out.mcap")]) == 0
    assert (tmp_path / "out.mcap").stat().st_size > 0


def test_a_full_disk_is_reported_and_leaves_nothing(
    log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["convert", str(log), "--out", "/dev/full"]) == 2
    assert_told_in_one_line("/dev/full: No space left", capsys)


@settings(max_examples=60, deadline=None, derandomize=True)
@given(
    cuts=st.lists(
        st.tuples(st.integers(0, 9_000), st.integers(0, 40), st.binary(max_size=60)), max_size=4
    )
)
def test_damage_loses_only_the_states_that_it_hits(
    cuts: list[tuple[int, int, bytes]], tmp_path_factory: pytest.TempPathFactory
) -> None:
    folder = tmp_path_factory.mktemp("damaged")
    write_boat(folder / "boat.tlog")
    content = (folder / "boat.tlog").read_bytes()
    for at, length, noise in cuts:
        content = content[:at] + noise + content[at + length :]
    (folder / "boat.tlog").write_bytes(content)
    states = converted(folder, folder / "out.mcap")["/boat2/state"]
    assert len(states) >= STEPS - 5 * len(cuts)


@pytest.mark.parametrize("place", [(math.nan, 0.0), (math.inf, 0.0), (1e30, 1e30)])
def test_an_invalid_position_is_left_out(place: tuple[float, float], tmp_path: Path) -> None:
    d, pen = dialect(), Pen()
    pen.put(START_US, 1, 1, d.MAVLink_gps_global_origin_message(*ORIGIN[::-1], 0))
    pen.put(START_US, 4, 1, d.MAVLink_gps_global_origin_message(*ORIGIN, 0))
    pen.put(START_US, 4, 1, d.MAVLink_attitude_message(0, 0, 0, math.inf, 0, 0, 0))
    pen.put(START_US, 4, 1, d.MAVLink_local_position_ned_message(0, *place, 0, 0, 0, 0))
    pen.put(START_US, 4, 1, d.MAVLink_position_target_local_ned_message(0, 1, 0, *place, *[0] * 9))
    pen.put(START_US, 4, 1, d.MAVLink_gps_global_origin_message(*ORIGIN[::-1], 0))
    pen.put(START_US, 4, 1, d.MAVLink_local_position_ned_message(1, 1.0, 2.0, 0, 0, 0, 0))
    (tmp_path / "boat.tlog").write_bytes(pen.content)
    topics = converted(tmp_path / "boat.tlog", tmp_path / "out.mcap")
    assert [(state.x_m, state.y_m) for _, state in topics["/boat4/state"]] == [(1.0, 2.0)]
    assert "/tf" not in topics  # the heading is unknown


def test_mavlogdump_prints_a_tlog_that_was_converted(log: Path) -> None:
    mavlogdump = Path(sys.executable).parent / "mavlogdump.py"
    command = [
        sys.executable,
        str(mavlogdump),
        "--types",
        "LOCAL_POSITION_NED",
        str(log / "mavlink0-00001.tlog"),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.count("LOCAL_POSITION_NED") >= STEPS


def test_a_log_is_not_written_over(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tlog = next(log.glob("*.tlog"))
    before = tlog.read_bytes()
    assert main(["convert", str(log), "--out", str(tlog)]) == 2
    assert_told_in_one_line("is one of the logs to convert", capsys)
    assert tlog.read_bytes() == before
