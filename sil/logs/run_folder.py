# SPDX-License-Identifier: MIT
"""Converts a run's folder to one MCAP file: the truth of trace.npz at 10 Hz, and the recording.

Poses, errors and thrusts are the simulation's truth; states, texts, the law's values, ages and ESCs
come from the boats' recorded messages. The release, t = 0, is at EPOCH_S.
"""

import json
from collections.abc import Callable, Iterator, Mapping
from math import cos, sin
from pathlib import Path
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from sil.lockstep import trace_file
from sil.lockstep.recording import CAN_IN, MAVLINK_OUT, Recording, of_run
from sil.logs.escs import EscBus
from sil.logs.output import Output, Pose
from sil.logs.telemetry import MESSAGES, Telemetry
from sil.plant.hull import Array
from sil.scenario.wiring import ORIGIN, VIRTUAL_LEADER_SYSTEM
from sil.wire.mavlink_frames import frames

EPOCH_S = 946_684_800  # 2000-01-01 00:00:00 UTC
RATE_HZ = 10.0
NAME = "run.mcap"
_RADIO = 1  # number of the radio's link
_US = 1_000_000

Progress = Callable[[float], None]


def convert(folder: Path, out: Path, progress: Progress) -> int:
    """Convert a run's folder to `out`; return the number of messages.

    A live run has no recording; then only the truth is written. ValueError for a damaged file.
    """
    trace = trace_file.read(folder)
    t_us = np.rint(1e6 * trace["t_s"]).astype(np.int64)
    boats = trace["error"].shape[1]
    with Output(ORIGIN) as output:
        wires = _Wires(output, _recording(folder), boats, int(t_us[-1]))
        step = max(1, round(1e6 / RATE_HZ / (t_us[1] - t_us[0]))) if t_us.size > 1 else 1
        for k in range(0, t_us.size, step):
            wires.until(int(t_us[k]))
            _tell(output, wires, trace, k, _ns(int(t_us[k])))
            progress(k / t_us.size)
        wires.until(int(t_us[-1]))
        output.write(out)
        progress(1.0)
        return output.messages


def _recording(folder: Path) -> Path | None:
    """The run's recording, if there is one; without a summary, any recording is accepted."""
    summary, recording = folder / "summary.json", folder / "recording.bin"
    if not summary.exists():
        return recording if recording.exists() else None
    try:
        digest = json.loads(summary.read_text(encoding="utf-8"))["digest"]
    except (ValueError, KeyError, TypeError):
        raise ValueError(
            f"{summary}: damaged, so the recording cannot be checked; remove it to convert without"
        ) from None
    return of_run(folder, digest)


def _ns(t_us: int) -> int:
    return 1000 * (EPOCH_S * _US + t_us)


def _tell(output: Output, wires: "_Wires", trace: Mapping[str, Array], k: int, t_ns: int) -> None:
    """Write one sample; skips vessels whose pose is not finite."""
    for agent, (eta, nu) in enumerate(zip(trace["eta"][k], trace["nu"][k], strict=True)):
        pose = Pose(*eta.tolist(), *nu.tolist())
        if not np.isfinite(pose).all():
            continue
        name = f"boat{agent}" if agent else f"leader{VIRTUAL_LEADER_SYSTEM}"
        output.pose(t_ns, name, pose)
        if not agent:
            continue
        e_x, e_y, e_psi = trace["error"][k, agent - 1].tolist()
        port_N, stbd_N = trace["thrust"][k, agent - 1].tolist()
        c, s = cos(pose.psi_rad), sin(pose.psi_rad)
        output.slot(t_ns, name, pose.x_m - (c * e_x - s * e_y), pose.y_m - (s * e_x + c * e_y))
        truth = {
            "error_x_m": e_x,
            "error_y_m": e_y,
            "error_psi_rad": e_psi,
            "error_m": float(np.hypot(e_x, e_y)),
            "thrust_port_N": port_N,
            "thrust_stbd_N": stbd_N,
        }
        said = wires.boats[agent].law(t_ns)
        output.own(t_ns, f"/{name}/law", "Law", {**said, **truth})


class _Wires:
    """The boats' recorded messages, written up to a given time; `boats`: telemetry by agent."""

    def __init__(self, output: Output, path: Path | None, boats: int, last_us: int) -> None:
        agents = range(1, boats + 1)
        self.boats = {i: Telemetry(output, f"boat{i}", tells_law=False) for i in agents}
        self._buses = {i: EscBus(output, f"boat{i}") for i in agents}
        self._mav = mavlink.MAVLink(None)
        self._records: Iterator[tuple[int, int, bytes]] = iter(())
        self._release_us = 0
        if path is not None:
            recording = Recording(path)
            # trace and recording end with the same tick
            self._release_us = max(t_us for t_us, _, _ in recording) - last_us
            self._records = iter(recording)
        self._next = next(self._records, None)

    def until(self, t_us: int) -> None:
        """Write everything up to `t_us` after the release."""
        while self._next is not None and self._next[0] - self._release_us <= t_us:
            at_us, port, data = self._next
            agent, channel = port >> 8, port & 0xFF
            if agent in self.boats:
                self._take(agent, channel, EPOCH_S * _US + at_us - self._release_us, data)
            self._next = next(self._records, None)

    def _take(self, agent: int, channel: int, unix_us: int, data: bytes) -> None:
        if channel == CAN_IN:
            self._buses[agent].on_frame(unix_us, int.from_bytes(data[:4], "little"), data[4:])
        elif channel == MAVLINK_OUT + _RADIO:
            for message_id, _, _, frame in frames(data):
                if message_id in MESSAGES:
                    message: Any = self._mav.decode(bytearray(frame))
                    self.boats[agent].take(1000 * unix_us, message)
