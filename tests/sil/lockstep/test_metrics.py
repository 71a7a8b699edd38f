# SPDX-License-Identifier: MIT
"""Figures of summary.json from made-up traces with known answers."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.distance import pdist

from sil.lockstep import metrics
from sil.plant.hull import Array
from sil.report.figures import REFERENCE

T_S = np.arange(0.0, 30.01, 0.1)


def along_x(distance: Array) -> Array:
    """Errors (T, 1, 3) of one boat that is `distance` ahead of its slot."""
    return np.stack([distance, 0.0 * distance, 0.0 * distance], axis=-1)[:, np.newaxis]


def entry(error: Array, thrust: Array | None = None) -> metrics.BoatSummary:
    given_thrust = np.zeros((T_S.size, 1, 2)) if thrust is None else thrust
    return metrics.boats(T_S, error, given_thrust, [{"FORMATION": 30.0}])[0]


def test_errors_of_the_reference_run_are_those_of_its_file() -> None:
    run = np.genfromtxt(REFERENCE, delimiter=",", names=True)
    eta = np.stack([[run[f"x{i}_m"], run[f"y{i}_m"], run[f"psi{i}_rad"]] for i in range(5)], axis=0)
    offset_m = np.array([[0.0, 0.0], [-2.0, -2.0], [4.0, 0.0], [-2.0, -2.0]])
    error = metrics.formation_error(np.moveaxis(eta, -1, 0), [0, 1, 2, 3], offset_m)
    names = [[f"ex{i}_m", f"ey{i}_m", f"epsi{i}_rad"] for i in range(1, 5)]
    expected = np.moveaxis(np.array([[run[name] for name in boat] for boat in names]), -1, 0)
    np.testing.assert_allclose(error, expected, rtol=0.0, atol=1e-6)


def test_boat_east_of_its_slot_and_heading_east_is_ahead_of_it() -> None:
    eta = np.array([[[0.0, 0.0, 0.0], [-2.0, 4.0, math.pi / 2]]])
    error = metrics.formation_error(eta, [0], np.array([[-2.0, 1.0]]))
    np.testing.assert_allclose(error, [[[3.0, 0.0, math.pi / 2]]], atol=1e-15)


@pytest.mark.parametrize("psi_leader", [0.0, 0.7, -2.5])
def test_slot_that_turns_is_ahead_and_to_starboard_of_its_leader(psi_leader: float) -> None:
    leader = np.array([10.0, -3.0, psi_leader])
    cos, sin = math.cos(psi_leader), math.sin(psi_leader)
    slot = leader[:2] + 2.0 * np.array([cos, sin]) + 1.0 * np.array([-sin, cos])
    own = np.array([*slot, psi_leader + 0.4])
    own[:2] += 0.3 * np.array([math.cos(own[2]), math.sin(own[2])])
    eta = np.array([[leader, own]])
    turning = metrics.formation_error(eta, [0], np.array([[2.0, 1.0]]), [True])
    np.testing.assert_allclose(turning, [[[0.3, 0.0, 0.4]]], atol=1e-12)
    fixed = metrics.formation_error(eta, [0], np.array([[2.0, 1.0]]), [False])
    assert np.array_equal(fixed, metrics.formation_error(eta, [0], np.array([[2.0, 1.0]])))
    assert (np.abs(fixed - turning).max() > 0.1) == (psi_leader != 0.0)


def test_each_slot_turns_or_not_by_its_own_setting() -> None:
    eta = np.array([[[0.0, 0.0, math.pi / 2], [0.0, 2.0, 0.0], [2.0, 0.0, 0.0]]])
    offset_m = np.array([[2.0, 0.0], [2.0, 0.0]])
    error = metrics.formation_error(eta, [0, 0], offset_m, [True, False])
    np.testing.assert_allclose(error[..., :2], 0.0, atol=1e-12)


def test_boats_that_follow_the_same_leader_are_measured_against_it() -> None:
    eta = np.array([[[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [1.0, 0.0, 0.0]]])
    error = metrics.formation_error(eta, [0, 0], np.zeros((2, 2)))
    np.testing.assert_allclose(error[0, :, 0], [5.0, 1.0])


def test_boat_with_its_stern_to_the_leaders_bow_errs_by_plus_pi() -> None:
    np.testing.assert_array_equal(metrics.wrap(np.array([-np.pi, np.pi])), [np.pi, np.pi])


@given(st.floats(-1e3, 1e3))
def test_wrapped_heading_error_is_the_same_direction_within_half_a_turn(angle: float) -> None:
    wrapped = float(metrics.wrap(np.array(angle)))
    assert -math.pi < wrapped <= math.pi
    assert math.remainder(wrapped - angle, math.tau) == pytest.approx(0.0, abs=1e-9)


def test_rms_and_maximum_look_at_the_last_third_only() -> None:
    distance = np.where(T_S < 20.0, 9.0, np.where(T_S < 25.0, 1.0, 2.0))
    boat = entry(along_x(distance))
    late = distance[200:]
    assert boat["max_error_m"] == 2.0
    assert boat["rms_error_m"] == pytest.approx(math.sqrt(np.mean(late**2)))


def test_boat_settles_when_it_enters_the_5_cm_for_good() -> None:
    distance = np.where(T_S < 12.05, 1.0, 0.04)
    distance[50:60] = 0.01
    assert entry(along_x(distance))["settling_time_s"] == pytest.approx(12.1)


def test_boat_on_its_slot_all_the_time_settles_at_release() -> None:
    assert entry(along_x(np.zeros_like(T_S)))["settling_time_s"] == 0.0


@pytest.mark.parametrize("last", [0.05, 3.0, math.nan])
def test_boat_outside_at_the_end_has_never_settled(last: float) -> None:
    distance = np.zeros_like(T_S)
    distance[-1] = last
    assert entry(along_x(distance))["settling_time_s"] is None


def test_distance_counts_both_axes_and_the_final_error_keeps_them_apart() -> None:
    boat = entry(np.tile([3.0, -4.0, 0.1], (T_S.size, 1, 1)))
    assert boat["max_error_m"] == pytest.approx(5.0)
    assert boat["final_error"] == {"x_m": 3.0, "y_m": -4.0, "psi_rad": 0.1}


def test_thrust_is_averaged_over_the_run_and_both_propellers() -> None:
    thrust = np.zeros((T_S.size, 1, 2))
    thrust[:, 0] = [3.0, -1.0]
    boat = entry(along_x(0.0 * T_S), thrust)
    assert boat["thrust_rms_N"] == pytest.approx(math.sqrt(5.0))
    assert boat["id"] == 1 and boat["states"] == {"FORMATION": 30.0}


def test_closest_encounter_is_between_boats_and_leaves_the_virtual_leader_out() -> None:
    eta = np.zeros((3, 4, 3))
    eta[:, 1, 0], eta[:, 2, 0], eta[:, 3, 0] = 0.0, 5.0, 20.0
    eta[1, 3, :2] = 5.0, 1.5
    assert metrics.min_separation_m(eta) == pytest.approx(1.5)
    assert metrics.min_separation_m(eta[:, :2]) is None


def drifting(boats: int, ticks: int, seed: int) -> Array:
    """Random poses (ticks, boats + 1, 3) of boats that move randomly."""
    rng = np.random.default_rng(seed)
    return 50.0 * rng.normal(size=(boats + 1, 3)) + np.cumsum(
        rng.normal(size=(ticks, boats + 1, 3)), axis=0
    )


@pytest.mark.parametrize(("boats", "ticks"), [(2, 50), (5, 400), (300, 20)])
def test_closest_encounter_is_that_of_all_pairs_at_all_times(boats: int, ticks: int) -> None:
    for seed in range(5):
        eta = drifting(boats, ticks, seed)
        expected = min(pdist(places[1:, :2]).min() for places in eta)
        assert metrics.min_separation_m(eta) == pytest.approx(expected, rel=1e-12)


def test_boats_with_nan_positions_hide_no_encounter_of_the_others() -> None:
    eta = drifting(12, 30, 1)
    eta[4:, 3], eta[9:, 8, 0], eta[2:5, 11, 1] = np.nan, np.inf, -np.inf
    places = np.where(np.isfinite(eta[..., :2]).all(axis=-1, keepdims=True), eta[..., :2], np.nan)
    expected = min(np.nanmin(pdist(row[1:])) for row in places)
    assert metrics.min_separation_m(eta) == pytest.approx(expected, rel=1e-12)


def test_heading_error_of_a_boat_with_nan_position_is_nan() -> None:
    assert np.isnan(metrics.wrap(np.array([np.nan]))).all()


def test_change_of_thrust_is_that_of_the_restless_propeller_in_the_last_third() -> None:
    thrust = np.zeros((T_S.size, 1, 2))
    thrust[:200, 0] = 50.0 * (-1.0) ** np.arange(200)[:, None]
    thrust[200:, 0, 0] = 0.1 * np.arange(T_S.size - 200)
    thrust[200:, 0, 1] = 0.3 * (-1.0) ** np.arange(T_S.size - 200)
    assert entry(along_x(0.0 * T_S), thrust)["thrust_step_rms_N"] == pytest.approx(0.6)
    each = metrics.thrust_step_rms_N(thrust[200:])
    np.testing.assert_allclose(each, [[0.1, 0.6]])


def test_figures_of_boats_with_nan_positions_are_made_without_a_warning() -> None:
    lost = along_x(np.full(T_S.size, 1e200))
    lost[-1] = np.inf
    assert np.isnan(metrics.wrap(np.array([np.inf, -np.inf]))).all()
    assert entry(lost)["rms_error_m"] == math.inf and entry(lost)["settling_time_s"] is None
