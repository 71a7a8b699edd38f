# SPDX-License-Identifier: MIT
"""Reads logs of any kind, chosen by the suffix of their names."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from sil.identify import read_telemetry
from sil.identify.read_csv import FULL_US, read_csv
from sil.identify.voyage_log import BadLogError, VoyageLog
from sil.logs.tlog_reader import facts


def read(paths: Sequence[Path]) -> tuple[list[VoyageLog], list[str]]:
    """Every log, and sentences about the assumptions.

    A folder stands for the telemetry logs in it or in its subfolder `log`; if a boat has one log
    for each link, for those of the navigation unit's link. If pulses of a table are outside
    1100 … 1900 µs, the pulse farthest from the stop in all logs is full thrust. Raises
    `BadLogError`, `OSError`.
    """
    logs, notes = [], []
    found = [file for given in paths for file in _files(given)]
    for k, path in enumerate(found):
        if path.resolve() in {earlier.resolve() for earlier in found[:k]}:
            raise BadLogError(f"{path}: is given twice; a log counts once")
        told: list[str] = []
        kind = path.suffix.lower()
        if kind == ".csv":
            log, told = read_csv(path)
        elif kind in (".tlog", ".bin"):
            reader = read_telemetry.read_tlog if kind == ".tlog" else read_telemetry.read_bin
            log = reader(path)
        else:
            raise BadLogError(f"{path}: unknown kind of log; supported are .csv, .tlog, .bin")
        logs.append(log)
        notes += [note for note in told if note not in notes]
    full = round(max(float(np.abs(log.commands).max()) for log in logs), 3)
    if full > 1.0:
        notes.append(f"full thrust is taken as {full * FULL_US:.0f} µs from the stop, not as 400")
        logs = [replace(log, commands=log.commands / full) for log in logs]
    return logs, notes


def _files(given: Path) -> list[Path]:
    if not given.is_dir():
        return [given]
    folder = given / "log" if (given / "log").is_dir() else given
    found = sorted(folder.glob("*.tlog"))
    if not found:
        raise BadLogError(f"{given}: contains no telemetry log (*.tlog)")
    return [path for path in found if facts(path).owner is not None] or found
