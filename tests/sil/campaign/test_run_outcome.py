# SPDX-License-Identifier: MIT
"""The results of a run, from made-up traces with known answers."""

import hashlib
import math

import numpy as np
import pytest

from sil.campaign.run_outcome import RunResult, distances, result_of
from sil.lockstep.start import StartError
from sil.lockstep.world import Run
from sil.scenario import scenario
from tests.sil.campaign.short import result

T_S = 0.01 * np.arange(30001)
SCENARIO = scenario.load("diamond", ["seed=5"])


def run(distance: np.ndarray, nu: float = 0.0) -> Run:
    """Two boats: one in its slot, the other `distance` (T) astern of its own."""
    error = np.zeros((T_S.size, 2, 3))
    error[:, 1, 0] = -distance
    error[:, 1, 2] = 0.25
    eta = np.zeros((T_S.size, 3, 3))
    eta[:, 2, 0] = 4.0 + distance
    velocity = np.full((T_S.size, 3, 3), nu)
    thrust = np.full((T_S.size, 2, 2), 3.0)
    trace = {"t_s": T_S, "eta": eta, "nu": velocity, "error": error, "thrust": thrust}
    return Run(trace, [{"FORMATION": 300.01}, {"FORMATION": 299.01, "HOLD": 1.0}], None)


def left_of(distance: np.ndarray, nu: float = 0.0) -> RunResult:
    return result_of(3, SCENARIO, run(distance, nu))


def test_figures_are_those_of_the_late_run() -> None:
    left = left_of(np.where(T_S < 160.0, 2.0, 0.5))
    assert (left.run, left.seed, left.outcome, left.reason) == (3, 5, "ok", "")
    figures = left.boats[1]
    # 60 s at 2 m and 140 s at 0.5 m after 100 s, more than half of the run at 2 m
    assert figures["error_p50_m"] == 0.5 and figures["error_p95_m"] == 2.0
    assert figures["rms_error_m"] == pytest.approx(0.5) and figures["final_x_m"] == -0.5
    assert figures["settling_time_s"] is None and left.boats[0]["settling_time_s"] == 0.0
    assert figures["thrust_rms_N"] == pytest.approx(3.0)
    assert left.min_separation_m == pytest.approx(4.5)
    assert left.states[1] == {"FORMATION": 299.01, "HOLD": 1.0}


def test_samples_are_at_the_whole_seconds() -> None:
    left = left_of(1e-3 * T_S)
    np.testing.assert_allclose(left.error_m[1], 1e-3 * np.arange(301), rtol=1e-6)
    assert left.error_m.shape == left.psi_rad.shape == (2, 301)
    assert left.error_m.dtype == np.float32 and np.all(left.psi_rad[1] == 0.25)


def test_digest_is_of_the_state_at_the_whole_seconds_and_shows_any_bit() -> None:
    changed = run(1e-3 * T_S)
    states = [changed.trace[name][::100].tobytes() for name in ("eta", "nu")]
    assert left_of(1e-3 * T_S).digest == hashlib.sha256(b"".join(states)).hexdigest()
    changed.trace["nu"][500, 1, 2] = np.nextafter(0.0, 1.0)
    assert result_of(3, SCENARIO, changed).digest != left_of(1e-3 * T_S).digest


@pytest.mark.parametrize(
    ("start_m", "late_m", "outcome"),
    [(1.0, 9.9, "ok"), (1.0, 10.1, "diverged"), (8.0, 15.9, "ok"), (8.0, 16.1, "diverged")],
)
def test_boat_far_from_its_slot_late_has_diverged(
    start_m: float, late_m: float, outcome: str
) -> None:
    distance = np.full(T_S.size, start_m)
    distance[25000] = late_m
    left = left_of(distance)
    assert left.outcome == outcome
    assert left.reason == ("" if outcome == "ok" else f"boat 2: {late_m} m from its slot")


def test_boat_far_from_its_slot_early_has_not_diverged() -> None:
    assert left_of(np.where(T_S < 199.0, 1000.0, 1.0)).outcome == "ok"


@pytest.mark.parametrize("nu", [math.inf, math.nan])
def test_state_that_is_not_finite_has_diverged(nu: float) -> None:
    left = left_of(np.ones(T_S.size), nu)
    assert left.outcome == "diverged" and "boat 1: state not finite" in left.reason
    assert left_of(np.where(T_S < 299.0, 1.0, nu)).outcome == "diverged"


@pytest.mark.parametrize("lost", ["eta", "nu"])
def test_virtual_leader_with_a_non_finite_state_has_diverged(lost: str) -> None:
    sailed = run(np.ones(T_S.size))
    sailed.trace[lost][29000:, 0, 1] = math.nan
    left = result_of(3, SCENARIO, sailed)
    assert left.outcome == "diverged" and left.reason == "virtual leader: state not finite"


def test_distance_that_is_nan_has_diverged() -> None:
    sailed = run(np.ones(T_S.size))
    sailed.trace["error"][:, 1, 0] = math.nan
    left = result_of(3, SCENARIO, sailed)
    assert left.outcome == "diverged" and left.reason == "boat 2: nan m from its slot"


def test_fleet_that_cannot_start_has_failed_with_the_reason() -> None:
    left = result_of(2, SCENARIO, StartError("boat 1: LOW BATTERY"))
    assert (left.run, left.seed, left.outcome) == (2, 5, "failed")
    assert left.reason == "boat 1: LOW BATTERY"
    assert left.boats == () and left.digest == "" and left.min_separation_m is None


def test_of_a_run_that_diverged_every_distance_is_infinite() -> None:
    runs = [result(0, [[1, 2], [3, 4]]), result(1, [[5, 6], [7, 8]], "diverged")]
    runs.append(RunResult(2, 7, "failed", "why"))
    np.testing.assert_array_equal(
        distances(runs), [[[1, 2], [3, 4]], [[math.inf] * 2, [math.inf] * 2]]
    )
