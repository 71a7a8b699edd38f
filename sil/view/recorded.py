# SPDX-License-Identifier: MIT
"""The history of a run: the truth of its trace, and what its boats said in its recording."""

import json
import zipfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sil import metrics, scenario
from sil.agents import systems_of
from sil.plant.hull import Array
from sil.scenario import Scenario
from sil.view.history import History, column, thinned
from sil.view.said import Places, Said, said_in
from sil.wiring import VIRTUAL_LEADER_SYSTEM

_LENGTH_M = 1.0


class Agent(NamedTuple):
    """What is known of one agent besides its motion; None where nothing is."""

    system: int
    length_m: float = _LENGTH_M
    leader: int | None = None
    limits_N: tuple[float, float] | None = None


def history_of_run(folder: Path, length_m: float | None = None) -> History:
    """The history of a folder that `sil run` or `sil live` left; `length_m`: of its boats.

    ValueError, in one line, where it has no trace.npz and summary.json.
    """
    try:
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        name, digest = str(summary["scenario"]), summary["digest"]
        with np.load(folder / "trace.npz") as arrays:
            trace = {key: arrays[key] for key in ("t_s", "eta", "nu", "error", "thrust")}
    except (OSError, ValueError, KeyError, TypeError, zipfile.BadZipFile) as error:
        raise ValueError(f"{folder} is not the folder of a run: {error}") from None
    try:
        sailed = scenario.load(name)
    except ValueError:
        sailed = None  # a file of somebody's own
    recording = folder / "recording.bin"
    # A live run leaves none; one that is there is of another run then.
    there = recording if digest is not None and recording.is_file() else None
    return history_of(f"{name}, seed {summary.get('seed')}", trace, sailed, there, length_m)


def history_of(
    title: str,
    trace: Mapping[str, Array],
    sailed: Scenario | None,
    recording: Path | None,
    length_m: float | None = None,
) -> History:
    """The history of a run whose trace is at hand: `trace` as in trace.npz.

    `sailed`: its scenario. ValueError for a recording that is none.
    """
    t_s = trace["t_s"]
    boats = trace["error"].shape[1]
    said = said_in(recording, 1e6 * float(t_s[-1])) if recording is not None else None
    agents = _agents(boats, sailed, said)
    if length_m is not None:
        agents = [agent._replace(length_m=length_m) for agent in agents]
    kept = thinned(t_s.size, boats + 1)
    vessels = [_vessel(i, agent, trace, kept, said) for i, agent in enumerate(agents)]
    return {"title": title, "t_s": column(t_s[kept]), "vessels": vessels}


def _agents(boats: int, sailed: Scenario | None, said: Said | None) -> list[Agent]:
    """The virtual leader and the boats: what the recording knows goes before the scenario."""
    agents = [Agent(VIRTUAL_LEADER_SYSTEM), *(Agent(i + 1) for i in range(boats))]
    if sailed is not None and len(sailed.boat) == boats:
        systems, vessels = systems_of(sailed), sailed.vessels()
        limits = [(-p.reverse_max_N, p.forward_max_N) for p in sailed.propeller_pairs()]
        leaders = [None, *(systems[boat.follows] for boat in sailed.boat)]
        agents = [
            Agent(
                system,
                vessel.length_m or _LENGTH_M,
                leader,
                limit,
            )
            for system, vessel, leader, limit in zip(
                systems, vessels, leaders, [None, *limits], strict=True
            )
        ]
    if said is not None and len(said.parameters) == boats:
        for i, own in enumerate(said.parameters, start=1):
            agents[i] = Agent(
                int(own["MAV_SYSID"]),
                agents[i].length_m,
                int(own["FORM_LEADER"]),
                (-own["THR_REV_MAX"], own["THR_FWD_MAX"]),
            )
    if len({agent.system for agent in agents}) < len(agents):
        # More than there are system ids: by their numbers, and who follows whom is not told.
        agents = [a._replace(system=i or -1, leader=None) for i, a in enumerate(agents)]
    return agents


def _vessel(
    i: int, agent: Agent, trace: Mapping[str, Array], kept: Places, said: Said | None
) -> dict[str, Any]:
    eta, nu = trace["eta"][kept, i], trace["nu"][kept, i]
    vessel: dict[str, Any] = {
        "id": agent.system,
        "kind": "boat" if i else "leader",
        "length_m": agent.length_m,
        "limits_N": agent.limits_N,
        "leader": agent.leader,
        "x_m": column(eta[:, 0]),
        "y_m": column(eta[:, 1]),
        "psi_rad": column(metrics.wrap(eta[:, 2])),
        "u_mps": column(nu[:, 0]),
        "v_mps": column(nu[:, 1]),
        "states": [],
        "held": [],
        "texts": [],
    }
    if i:
        error, thrust = trace["error"][kept, i - 1], trace["thrust"][kept, i - 1]
        c, s = np.cos(eta[:, 2]), np.sin(eta[:, 2])
        vessel |= {
            "slot_x_m": column(eta[:, 0] - c * error[:, 0] + s * error[:, 1]),
            "slot_y_m": column(eta[:, 1] - s * error[:, 0] - c * error[:, 1]),
            "error_m": column(metrics.distances(error)),
            "thrust_port_N": column(thrust[:, 0]),
            "thrust_stbd_N": column(thrust[:, 1]),
        }
        if said is not None:
            vessel |= said.of(i, trace["t_s"][kept])
    return vessel
