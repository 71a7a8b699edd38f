# SPDX-License-Identifier: MIT
"""Logs of boats: tlogs written by pymavlink, CAN frames by PyPI dronecan, a DataFlash log."""

import struct
from dataclasses import replace
from pathlib import Path
from typing import Any

import dronecan
import numpy as np
import pytest
from dronecan.transport import Transfer
from pymavlink.dialects.v20 import common as mavlink

from sil.identify.log_files import read
from sil.identify.voyage_log import Array, BadLogError, VoyageLog
from tests.sil.identify.sailed import Noise, levels, sail

Heard = tuple[int, int, int, mavlink.MAVLink_message]
BEGIN_US = 1_700_000_000_000_000


@pytest.fixture(scope="module")
def truth() -> VoyageLog:
    rng = np.random.default_rng(8)
    return sail(levels(rng, 40.0), rng, Noise(0.0, 0.0, 0.0, 0.0))


def times(log: VoyageLog) -> list[int]:
    return [BEGIN_US + 100_000 * k for k in range(len(log.motion))]


def over_ground(motion: Array) -> tuple[Array, Array]:
    psi, u, v = motion[:, 2], motion[:, 3], motion[:, 4]
    return np.cos(psi) * u - np.sin(psi) * v, np.sin(psi) * u + np.cos(psi) * v


def tlog(*heard: Heard) -> bytes:
    """Of (t_us, system, component, message)."""
    out = bytearray()
    for t_us, system, component, message in sorted(heard, key=lambda row: row[0]):
        pen = mavlink.MAVLink(None, srcSystem=system, srcComponent=component)
        out += t_us.to_bytes(8, "big") + message.pack(pen)
    return bytes(out)


def attitude_and_place(
    log: VoyageLog, system: int, component: int, north_m: float = 0.0
) -> list[Heard]:
    rows: list[Heard] = []
    vn, ve = over_ground(log.motion)
    for k, t_us in enumerate(times(log)):
        n, e, psi, _, _, r = log.motion[k]
        wrapped = (psi + np.pi) % (2.0 * np.pi) - np.pi
        attitude = mavlink.MAVLink_attitude_message(0, 0, 0, wrapped, 0, 0, r)
        place = mavlink.MAVLink_local_position_ned_message(0, n + north_m, e, 0, vn[k], ve[k], 0)
        rows += [(t_us, system, component, attitude), (t_us, system, component, place)]
    return rows


def servos(log: VoyageLog, system: int, port: int, stbd: int) -> list[Heard]:
    rows = []
    for t_us, (p, s) in zip(times(log), log.commands, strict=True):
        pulses = [0] * 8
        pulses[port - 1], pulses[stbd - 1] = round(1500 + 400 * p), round(1500 + 400 * s)
        rows.append((t_us, system, 1, mavlink.MAVLink_servo_output_raw_message(0, 0, *pulses)))
    return rows


def parameter(name: str, value: float) -> Heard:
    message = mavlink.MAVLink_param_value_message(name.encode(), value, 9, 1, 0)
    return BEGIN_US, 3, 1, message


def check(log: VoyageLog, truth: VoyageLog, commands: float = 0.003) -> None:
    count = min(len(log.motion), len(truth.motion))
    assert count > len(truth.motion) - 3
    turns = np.round((log.motion[0, 2] - truth.motion[0, 2]) / (2 * np.pi)) * 2 * np.pi
    assert np.allclose(log.motion[:count] - [0, 0, turns, 0, 0, 0], truth.motion[:count], atol=1e-3)
    assert np.allclose(log.commands[:count], truth.commands[:count], atol=commands)


def test_ardupilots_tlog_is_read_with_the_outputs_named_by_its_parameters(
    truth: VoyageLog, tmp_path: Path
) -> None:
    told = [parameter("SERVO4_FUNCTION", 73.0), parameter("SERVO2_FUNCTION", 74.0)]
    content = tlog(*attitude_and_place(truth, 3, 1), *servos(truth, 3, 4, 2), *told)
    (tmp_path / "rover.tlog").write_bytes(content)
    ((log,), _) = read([tmp_path / "rover.tlog"])
    check(log, truth)


def can_log(truth: VoyageLog, rows: slice, port: int = 0, stbd: int = 1) -> str:
    """Of the commands of a part of a voyage; `port`, `stbd`: indices of the ESCs."""
    lines = []
    for k in range(len(truth.commands))[rows]:
        t_us, cmd = times(truth)[k], [0] * (max(port, stbd) + 1)
        cmd[port], cmd[stbd] = (round(8191 * c) for c in truth.commands[k])
        raw = dronecan.uavcan.equipment.esc.RawCommand(cmd=cmd)
        for frame in Transfer(k % 32, 10, payload=raw, transfer_priority=8).to_frames():
            at = f"{t_us // 1_000_000}.{t_us % 1_000_000:06d}"
            lines.append(f"({at}) can0 {frame.message_id:08X}#{bytes(frame.bytes).hex().upper()}\n")
    return "".join(lines)


def test_flotillads_logs_are_read_from_their_folder_without_a_leaders_motion(
    truth: VoyageLog, tmp_path: Path
) -> None:
    vessel = mavlink.MAVLink_local_position_ned_message(0, 500.0, 0, 0, 0, 0, 0)
    own = [(t, 3, 1, vessel) for t in times(truth)] * 2  # of the boat itself, for others
    foreign = attitude_and_place(truth, 7, 1, north_m=900.0)
    (tmp_path / "log").mkdir()
    content = tlog(*attitude_and_place(truth, 3, 191), *own, *foreign)
    (tmp_path / "log" / "mavlink0-00001.tlog").write_bytes(content)
    (tmp_path / "log" / "mavlink1-00001.tlog").write_bytes(tlog(*own, *foreign))  # the radio
    # The bus's logs count for themselves, and go on in a new file.
    half = len(truth.commands) // 2
    earlier = "(1600000000.000000) can0 0704060A#0000C0\n"
    (tmp_path / "log" / "can-00001.log").write_text(earlier)
    (tmp_path / "log" / "can-00002.log").write_text(can_log(truth, slice(0, half)))
    (tmp_path / "log" / "can-00003.log").write_text(can_log(truth, slice(half, None)))
    ((log,), _) = read([tmp_path])
    check(log, truth, 1e-3)


def test_propellers_are_those_that_the_boats_parameters_name(
    truth: VoyageLog, tmp_path: Path
) -> None:
    told = [parameter("ESC_PORT", 3.0), parameter("ESC_STBD", 1.0)]
    content = tlog(*attitude_and_place(truth, 3, 191), *told)
    (tmp_path / "mavlink0-00001.tlog").write_bytes(content)
    (tmp_path / "can-00001.log").write_text(can_log(truth, slice(None), port=3, stbd=1))
    ((log,), _) = read([tmp_path / "mavlink0-00001.tlog"])
    check(log, truth, 1e-3)


def test_odometry_is_enough(truth: VoyageLog, tmp_path: Path) -> None:
    rows = []
    for t_us, (n, e, psi, u, v, r) in zip(times(truth), truth.motion, strict=True):
        q = [np.cos(psi / 2), 0.0, 0.0, np.sin(psi / 2)]
        none = [float("nan")] * 21
        message = mavlink.MAVLink_odometry_message(
            0, 1, 8 + 4, n, e, 0, q, u, v, 0, 0, 0, r, none, none
        )
        rows.append((t_us, 3, 191, message))
    (tmp_path / "boat.tlog").write_bytes(tlog(*rows, *servos(truth, 3, 1, 3)))
    ((log,), _) = read([tmp_path / "boat.tlog"])
    check(log, truth)


def test_a_log_without_propeller_commands_is_refused(truth: VoyageLog, tmp_path: Path) -> None:
    (tmp_path / "rover.tlog").write_bytes(tlog(*attitude_and_place(truth, 3, 1)))
    with pytest.raises(BadLogError, match="no propeller commands"):
        read([tmp_path / "rover.tlog"])


def test_positions_that_are_no_numbers_are_missing(truth: VoyageLog, tmp_path: Path) -> None:
    nowhere = replace(truth, motion=truth.motion.copy())
    nowhere.motion[:, :2] = np.nan
    rows = attitude_and_place(nowhere, 3, 1) + servos(truth, 3, 1, 3)
    (tmp_path / "rover.tlog").write_bytes(tlog(*rows))
    with pytest.raises(BadLogError, match="contains no position"):
        read([tmp_path / "rover.tlog"])


def test_a_propeller_on_an_output_that_is_not_logged_is_named(
    truth: VoyageLog, tmp_path: Path
) -> None:
    told = [parameter("SERVO4_FUNCTION", 73.0), parameter("SERVO17_FUNCTION", 74.0)]
    content = tlog(*attitude_and_place(truth, 3, 1), *servos(truth, 3, 4, 2), *told)
    (tmp_path / "rover.tlog").write_bytes(content)
    with pytest.raises(BadLogError, match=r"rover.tlog: SERVO17_FUNCTION .* 1 to 16"):
        read([tmp_path / "rover.tlog"])


def test_a_ground_stations_log_of_several_vessels_is_refused(
    truth: VoyageLog, tmp_path: Path
) -> None:
    both = attitude_and_place(truth, 3, 1) + attitude_and_place(truth, 4, 1)
    (tmp_path / "gcs.tlog").write_bytes(tlog(*both))
    with pytest.raises(BadLogError, match="several vessels"):
        read([tmp_path / "gcs.tlog"])


FORMATS = {  # name: id, DataFlash format, labels
    "PARM": (10, "QNf", "TimeUS,Name,Value"),
    "IMU": (11, "QBf", "TimeUS,I,GyrZ"),
    "XKF1": (12, "QBfffff", "TimeUS,C,Yaw,VN,VE,PN,PE"),
    "RCOU": (13, "QHHHH", "TimeUS,C1,C2,C3,C4"),
}


def dataflash(rows: list[tuple[Any, ...]]) -> bytes:
    """A .bin, by ArduPilot's documentation: A3 95, id, fields without gaps."""
    letters = {"Q": "Q", "N": "16s", "f": "f", "B": "B", "H": "H", "n": "4s", "Z": "64s"}

    def packed(kind: int, form: str, *values: object) -> bytes:
        body = struct.pack("<" + "".join(letters[c] for c in form), *values)
        return bytes([0xA3, 0x95, kind]) + body

    out = b""
    described = {"FMT": (128, "BBnNZ", "Type,Length,Name,Format,Columns"), **FORMATS}
    for name, (kind, form, labels) in described.items():
        size = 3 + struct.calcsize("<" + "".join(letters[c] for c in form))
        texts = name.encode(), form.encode(), labels.encode()
        out += packed(128, "BBnNZ", kind, size, *texts)
    for name, *values in rows:
        kind, form, _ = FORMATS[name]
        out += packed(kind, form, *values)
    return out


def test_ardupilots_dataflash_log_is_read(truth: VoyageLog, tmp_path: Path) -> None:
    vn, ve = over_ground(truth.motion)
    rows: list[tuple[Any, ...]] = [
        ("PARM", 1, b"SERVO1_FUNCTION", 74.0),
        ("PARM", 1, b"SERVO3_FUNCTION", 73.0),
    ]
    for k, t_us in enumerate(times(truth)):
        n, e, psi, _, _, r = truth.motion[k]
        t = t_us - BEGIN_US + 5_000_000
        p, s = (round(1500 + 400 * c) for c in truth.commands[k])
        yaw = float(np.degrees(psi) % 360.0)
        rows += [
            ("IMU", t, 0, r),
            ("IMU", t, 1, 9.0),
            ("XKF1", t, 0, yaw, vn[k], ve[k], n, e),
            ("XKF1", t, 1, 0.0, 9.0, 9.0, 99.0, 99.0),
            ("RCOU", t, s, 0, p, 0),
        ]
    (tmp_path / "ROVER.BIN").write_bytes(dataflash(rows))
    ((log,), _) = read([tmp_path / "ROVER.BIN"])
    check(log, truth)


@pytest.mark.parametrize("content", [b"", b"t_s,port,stbd\n"])
def test_a_bin_that_is_no_dataflash_log_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "log.bin").write_bytes(content)
    with pytest.raises(BadLogError, match=r"log\.bin: is no DataFlash log"):
        read([tmp_path / "log.bin"])


def test_a_file_of_another_kind_is_refused(tmp_path: Path) -> None:
    (tmp_path / "log.ulg").write_bytes(b"ULog")
    with pytest.raises(BadLogError, match=r"\.csv, \.tlog, \.bin"):
        read([tmp_path / "log.ulg"])
