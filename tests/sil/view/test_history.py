# SPDX-License-Identifier: MIT
"""Histories for a replay page, from made-up traces."""

import base64
import json
import struct

import numpy as np
import pytest

from sil.lockstep import metrics
from sil.lockstep.recording import MOST_BOATS
from sil.plant.hull import Array
from sil.scenario import scenario
from sil.scenario.wiring import VIRTUAL_LEADER_SYSTEM
from sil.view import history
from sil.view.history import Boat

OFFSET_M = np.array([[-3.0, 1.0], [2.0, -4.0]])
TURNS = [0.0, 1.0]


def trace(ticks: int = 5001) -> dict[str, Array]:
    rng = np.random.default_rng(9)
    eta = np.cumsum(rng.normal(0.0, 0.1, (ticks, 3, 3)), axis=0)
    return {
        "t_s": np.asarray(0.01 * np.arange(ticks), float),
        "eta": eta,
        "nu": rng.normal(0.0, 1.0, (ticks, 3, 3)),
        "error": metrics.formation_error(eta, [0, 1], OFFSET_M, TURNS),
        "thrust": rng.normal(0.0, 5.0, (ticks, 2, 2)),
    }


def test_column_is_little_endian_float32_and_what_is_not_finite_is_nan() -> None:
    raw = base64.b64decode(history.column([1.5, -2.0, np.inf, np.nan, 1e300]))
    assert struct.unpack("<2f", raw[:8]) == (1.5, -2.0)
    assert np.isnan(np.frombuffer(raw[8:], "<f4")).all()


def test_column_can_be_read_back() -> None:
    values = np.linspace(-7.0, 7.0, 33)
    assert history.numbers(history.column(values)) == pytest.approx(values, abs=1e-6)


@pytest.mark.parametrize("count", [1, 2, 1199, 1200, 1201, 30001])
def test_samples_are_kept_evenly_with_the_first_and_the_last(count: int) -> None:
    every = history.kept(count)
    assert every[0] == 0 and every[-1] == count - 1 and every.size == min(count, 1200)
    assert np.ptp(np.diff(every)) <= 1 if count > 2 else True


def test_history_of_a_trace_is_plain_json_with_columns_of_one_length() -> None:
    told = json.loads(json.dumps(history.of_trace(trace(), "a run"), allow_nan=False))
    assert told["title"] == "a run"
    columns = [told["t_s"], *(v[k] for v in told["vessels"] for k in history.COLUMNS if k in v)]
    assert {history.numbers(text).size for text in columns} == {history.MOST_SAMPLES}
    assert [(v["kind"], v["id"]) for v in told["vessels"]] == [
        ("leader", VIRTUAL_LEADER_SYSTEM),
        ("boat", 1),
        ("boat", 2),
    ]


def test_slots_are_the_leaders_place_and_the_offset_in_either_frame() -> None:
    run = trace()
    told = history.of_trace(run, "a run")["vessels"]
    every = history.kept(run["t_s"].size)
    leader, first = run["eta"][every, 0], run["eta"][every, 1]
    cos, sin = np.cos(first[:, 2]), np.sin(first[:, 2])
    wanted = (
        leader[:, :2] + OFFSET_M[0],
        first[:, :2] + np.column_stack([2.0 * cos + 4.0 * sin, 2.0 * sin - 4.0 * cos]),
    )
    for vessel, slot in zip(told[1:], wanted, strict=True):
        assert history.numbers(vessel["slot_x_m"]) == pytest.approx(slot[:, 0], abs=1e-4)
        assert history.numbers(vessel["slot_y_m"]) == pytest.approx(slot[:, 1], abs=1e-4)
    assert "slot_x_m" not in told[0] and "error_m" not in told[0]


def test_ids_leaders_lengths_and_limits_come_from_the_boats() -> None:
    boats = [Boat(7, VIRTUAL_LEADER_SYSTEM, 2.0, (-20.0, 50.0)), Boat(8, 7)]
    told = history.of_trace(trace(), "a run", boats)["vessels"]
    assert [(v["id"], v["leader"], v["length_m"], v["limits_N"]) for v in told] == [
        (VIRTUAL_LEADER_SYSTEM, None, history.LENGTH_M, None),
        (7, VIRTUAL_LEADER_SYSTEM, 2.0, [-20.0, 50.0]),
        (8, 7, history.LENGTH_M, None),
    ]


def test_trace_without_velocities_and_thrusts_has_no_such_columns() -> None:
    nominal = {name: values for name, values in trace().items() if name in ("t_s", "eta", "error")}
    boat = history.of_trace(nominal, "nominal")["vessels"][1]
    assert "u_mps" not in boat and "thrust_port_N" not in boat and "error_m" in boat


def test_diverged_run_has_nan_where_it_is_not_finite() -> None:
    run = trace()
    run["eta"][3000:, 1] = np.inf
    run["error"][3000:, 0] = np.nan
    boat = history.of_trace(run, "lost")["vessels"][1]
    lost = np.isnan(history.numbers(boat["slot_x_m"]))
    assert lost[-1] and not lost[0] and np.isnan(history.numbers(boat["x_m"])[-1])


def test_boats_of_a_scenario_have_its_ids_leaders_hulls_and_limits() -> None:
    changes = ["boat.2.vessel.length_m=2.5", "propellers.reverse_max_N=30"]
    boats = history.boats_of(scenario.load("diamond", changes))
    follows = [boat.follows for boat in scenario.load("diamond").boat]
    assert [boat.id for boat in boats] == [1, 2, 3, 4]
    assert [boat.leader for boat in boats] == [i or VIRTUAL_LEADER_SYSTEM for i in follows]
    assert [boat.length_m for boat in boats] == [1.0, 2.5, 1.0, 1.0]
    assert {boat.limits_N for boat in boats} == {(-30.0, 50.0)}
    assert [boat.leader for boat in history.boats_of(scenario.load("lead"))] == [None, 1, 1, 1]


def test_boats_beyond_the_system_ids_are_numbered() -> None:
    few = scenario.load("diamond")
    many = few.model_copy(update={"boat": few.boat * 70})
    boats = history.boats_of(many)
    assert [boat.id for boat in boats] == list(range(1, 281))
    assert {boat.leader for boat in boats} == {None}


@pytest.mark.parametrize("boats", [1, 4, 20, 1000])
def test_history_of_many_boats_stays_one_that_a_page_can_carry(boats: int) -> None:
    samples = history.most_samples(boats + 1)
    assert 60 <= samples <= 1200
    # of more boats than a recording has room for only the truth is known
    told = history.of_trace(trace(2), "")["vessels"][1]
    true = [name for name in history.COLUMNS if name in told]
    columns = len(history.COLUMNS if boats <= MOST_BOATS else true)
    assert samples * columns * (boats + 1) <= 1_000_000


def test_column_that_no_history_has_is_refused() -> None:
    with pytest.raises(ValueError, match="unknown columns of a history: speed"):
        history.vessel(Boat(1), "boat", {"speed": [1.0]})
