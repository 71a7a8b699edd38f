# SPDX-License-Identifier: MIT
"""The data of a replay page: one JSON object with a run's vessels over time.

A history is `{"title", "t_s", "vessels": [{"id", "kind", "length_m", "limits_N", "leader", …}]}`.
Quantities that change are columns of the same length as `t_s`: base64 of little-endian float32, NaN
if unknown; a column without any known value is absent. `states`, `held`, `texts` with their
`severities` (MAV_SEVERITY), `plans` (see `sil.view.seen_plan.drawn`) and `items` (the one ahead)
are lists of [t_s, value], each value valid from its time on, None if unknown again. `origin_deg`,
if known: latitude and longitude of the origin of all positions. `plan_of`: if the first vessel is
the plan of a boat that leads, that boat's id.
"""

import base64
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from sil.plant.hull import Array
from sil.scenario.agents import systems_of
from sil.scenario.scenario import Scenario
from sil.scenario.wiring import VIRTUAL_LEADER_SYSTEM
from sil.view.aboard import ESC_NUMBERS

MOST_SAMPLES = 1200
_MOST_NUMBERS, _LEAST_SAMPLES = 500_000, 60
LENGTH_M = 1.0  # for hulls of unknown length, as in `sil.report.plots`
SIDES = ("port", "stbd")  # of the ESCs
COLUMNS = (
    "x_m",
    "y_m",
    "psi_rad",
    "u_mps",
    "v_mps",
    "slot_x_m",
    "slot_y_m",
    "error_m",
    "in_slot",
    "conditions_lost_s",
    "senders",
    "unknown_mode",
    "thrust_port_N",
    "thrust_stbd_N",
    "link_age_s",
    "place_age_s",
    "leader_age_s",
    "battery_V",
    *(f"{side}_{name}" for side in SIDES for name in ESC_NUMBERS),
)


@dataclass(frozen=True)
class Boat:
    """A boat's constants, which a trace lacks; `leader` and `id` are system ids.

    `limits_N`: least (negative or 0) and greatest thrust of one propeller.
    """

    id: int
    leader: int | None = None
    length_m: float = LENGTH_M
    limits_N: tuple[float, float] | None = None


def column(values: npt.ArrayLike) -> str:
    """Encode numbers (T) for a history: base64 of little-endian float32, infinite ones as NaN."""
    with np.errstate(over="ignore"):
        numbers = np.asarray(values, np.float64).astype("<f4")
    numbers[~np.isfinite(numbers)] = np.nan
    return base64.b64encode(numbers.tobytes()).decode("ascii")


def numbers(text: str) -> npt.NDArray[np.float32]:
    """Decode a text of `column`: numbers (T), float32."""
    return np.frombuffer(base64.b64decode(text, validate=True), "<f4")


def boats_of(scenario: Scenario) -> list[Boat]:
    """The boats of a scenario, boat 1 first, without the virtual leader.

    With more boats than there are system ids, `id` is the boat's number and `leader` is None, as
    for a boat that sails a plan.
    """
    systems = systems_of(scenario)
    unique = len(set(systems)) == len(systems)
    leaders = [scenario.heard_by(agent) for agent in range(1, len(systems))]
    pairs = zip(leaders, scenario.propeller_pairs(), scenario.vessels()[1:], strict=True)
    return [
        Boat(
            systems[agent] if unique else agent,
            systems[leader] if unique and leader != agent else None,
            vessel.length_m or LENGTH_M,
            (-propellers.reverse_max_N, propellers.forward_max_N),
        )
        for agent, (leader, propellers, vessel) in enumerate(pairs, start=1)
    ]


def most_samples(vessels: int) -> int:
    """Number of samples in a history of that many vessels; this bounds the page's size."""
    return max(_LEAST_SAMPLES, min(MOST_SAMPLES, _MOST_NUMBERS // (len(COLUMNS) * vessels)))


def kept(count: int, most: int = MOST_SAMPLES) -> npt.NDArray[np.int64]:
    """Indices of the samples to keep: at most `most`, evenly spread from the first to the last."""
    if count <= most:
        return np.arange(count)
    return np.linspace(0, count - 1, most).round().astype(np.int64)


def vessel(about: Boat, kind: str, columns: Mapping[str, npt.ArrayLike]) -> dict[str, Any]:
    """An entry of a history's `vessels`; `columns`: thinned arrays (T) by names of `COLUMNS`.

    Its lists of changes, `states` to `items`, are empty, for the caller to fill.
    """
    if unknown := set(columns) - set(COLUMNS):
        raise ValueError(f"unknown columns of a history: {', '.join(sorted(unknown))}")
    return {
        "id": about.id,
        "kind": kind,
        "length_m": about.length_m,
        "limits_N": None if about.limits_N is None else list(about.limits_N),
        "leader": about.leader,
        **{name: column(values) for name, values in columns.items()},
        "states": [],
        "held": [],
        "texts": [],
        "severities": [],
        "plans": [],
        "items": [],
    }


def of_trace(
    trace: Mapping[str, Array], title: str, boats: Sequence[Boat] | None = None
) -> dict[str, Any]:
    """The history of a run from its trace alone: arrays as in trace.npz, (T, N+1, …) and (T, N, …).

    Requires `t_s`, `eta` and `error`; uses `nu` and `thrust` if present. `boats` (N): boat 1
    first; without them the leaders are unknown. The virtual leader is the first vessel.
    Slots follow from the boats' errors: p_slot = p − R(ψ) [e_x e_y].
    """
    every = kept(trace["t_s"].size, most_samples(trace["eta"].shape[1]))
    sampled = {name: values[every] for name, values in trace.items()}
    eta = sampled["eta"]
    if boats is None:
        boats = [Boat(agent) for agent in range(1, eta.shape[1])]
    leader = Boat(VIRTUAL_LEADER_SYSTEM)
    vessels = [vessel(leader, "leader", _motion(sampled, 0))]
    vessels += [
        vessel(boat, "boat", {**_motion(sampled, agent), **_slot(sampled, agent)})
        for agent, boat in enumerate(boats, start=1)
    ]
    return {"title": title, "t_s": column(sampled["t_s"]), "vessels": vessels}


def _motion(trace: Mapping[str, Array], agent: int) -> dict[str, Array]:
    columns = {name: trace["eta"][:, agent, i] for i, name in enumerate(("x_m", "y_m", "psi_rad"))}
    if "nu" in trace:
        columns |= {name: trace["nu"][:, agent, i] for i, name in enumerate(("u_mps", "v_mps"))}
    return columns


def _slot(trace: Mapping[str, Array], agent: int) -> dict[str, Array]:
    """Columns that only boats have: slot, error, thrusts."""
    x, y, psi = trace["eta"][:, agent].T
    e_x, e_y, _ = trace["error"][:, agent - 1].T
    # a diverged run has values that are not finite
    with np.errstate(all="ignore"):
        columns = {
            "slot_x_m": x - (np.cos(psi) * e_x - np.sin(psi) * e_y),
            "slot_y_m": y - (np.sin(psi) * e_x + np.cos(psi) * e_y),
            "error_m": np.hypot(e_x, e_y),
        }
    if "thrust" in trace:
        port, stbd = trace["thrust"][:, agent - 1].T
        columns |= {"thrust_port_N": port, "thrust_stbd_N": stbd}
    return columns
