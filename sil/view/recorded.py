# SPDX-License-Identifier: MIT
"""The history of a run: the truth from its trace, and its boats' recorded messages."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from sil.lockstep import recording, trace_file
from sil.plant.hull import Array
from sil.scenario import scenario
from sil.scenario.scenario import Scenario
from sil.scenario.wiring import ORIGIN
from sil.view import history
from sil.view.history import Boat
from sil.view.said import Said, said_in, said_live

_OF_SLOTS = ("slot_x_m", "slot_y_m", "error_m", "in_slot")


def history_of_run(folder: Path, length_m: float | None = None) -> dict[str, Any]:
    """The history of a folder of `flotilla run` or `flotilla live`; `length_m`: of its boats.

    ValueError, in one line, unless the folder has a valid trace.npz and summary.json.
    """
    try:
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        name, digest = str(summary["scenario"]), summary["digest"]
        released = summary.get("release_unix_s")
        release_unix_s = None if released is None else float(released)
        trace = trace_file.read(folder)
    except OSError as error:
        lacking = f"{Path(error.filename or folder).name}: {error.strerror}"
        raise ValueError(f"{folder} is not the folder of a run: {lacking}") from None
    except (ValueError, KeyError, TypeError) as error:
        raise ValueError(f"{folder} is not the folder of a run: {error}") from None
    try:
        sailed = scenario.load(name)
    except ValueError:
        sailed = None  # not one of the project's scenarios
    there = recording.of_run(folder, digest)
    said = said_of(folder, trace, there, release_unix_s)
    told = history_of(f"{name}, seed {summary.get('seed')}", trace, sailed, said, length_m)
    return without_slots(told) if "voyage" in summary else told


def said_of(
    folder: Path,
    trace: Mapping[str, Array],
    recorded: Path | None,
    release_unix_s: float | None = None,
) -> Said | None:
    """The boats' messages: from a live run's logs in its folder, else from `recorded`; ValueError.

    None if there is no recording.
    """
    if release_unix_s is not None:
        return said_live(folder, trace, release_unix_s)
    return None if recorded is None else said_in(recorded, 1e6 * float(trace["t_s"][-1]))


def history_of(
    title: str,
    trace: Mapping[str, Array],
    sailed: Scenario | None,
    said: Said | None,
    length_m: float | None = None,
) -> dict[str, Any]:
    """The history of a run from its `trace`, arrays as in trace.npz.

    `sailed`: its scenario, `said`: its boats' messages, None if unknown.
    """
    boats = trace["error"].shape[1]
    about = _boats(boats, sailed, said)
    if length_m is not None:
        about = [replace(boat, length_m=length_m) for boat in about]
    told = history.of_trace(trace, title, about)
    if sailed is not None and sailed.leader.boat is not None:
        told["vessels"][0]["plan_of"] = sailed.leader.boat
    told["origin_deg"] = [1e-7 * ORIGIN[0], 1e-7 * ORIGIN[1]]
    if said is not None and len(said.boats) == boats:
        kept_s = history.numbers(told["t_s"])
        for boat, vessel in zip(said.boats, told["vessels"][1:], strict=True):
            vessel.update(boat.told(kept_s))
    return told


def without_slots(history: dict[str, Any]) -> dict[str, Any]:
    """The same history without the boats' slots and errors, for a voyage that has none."""
    for vessel in history["vessels"]:
        for name in _OF_SLOTS:
            vessel.pop(name, None)
    return history


def _boats(count: int, sailed: Scenario | None, said: Said | None) -> list[Boat]:
    """The boats' constants; values of the recording take precedence over the scenario's."""
    boats = [Boat(agent) for agent in range(1, count + 1)]
    if sailed is not None and len(sailed.boat) == count:
        boats = history.boats_of(sailed)
    if said is not None and len(said.parameters) == count:
        boats = [
            Boat(
                int(own["MAV_SYSID"]),
                int(own["FORM_LEADER"]),
                boat.length_m,
                (-own["THR_REV_MAX"], own["THR_FWD_MAX"]),
            )
            for boat, own in zip(boats, said.parameters, strict=True)
        ]
    if len({boat.id for boat in boats}) < count:
        # More boats than system ids: use their numbers, and leave the leaders unknown.
        boats = [replace(boat, id=i, leader=None) for i, boat in enumerate(boats, start=1)]
    return boats
