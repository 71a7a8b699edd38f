# SPDX-License-Identifier: MIT
"""Figures from made-up traces with known answers."""

import math

import numpy as np
import pytest

from sil.lockstep import metrics
from sil.plant.hull import Array
from sil.report import figures
from sil.report.figures import Trace

T_S: Array = np.arange(0.0, 300.005, 0.1)
REFERENCE = np.genfromtxt(figures.REFERENCE, delimiter=",", names=True)


def at_distances(*distances: Array) -> Trace:
    """Boats whose slots are to port, at these distances (T), and that turn no propeller."""
    error = np.stack([np.stack([0 * d, d, 0 * d], axis=-1) for d in distances], axis=1)
    return {"t_s": T_S, "error": error, "thrust": np.zeros((T_S.size, len(distances), 2))}


def test_worst_boat_gives_the_error_settling_and_effort_of_summary_json() -> None:
    rng = np.random.default_rng(4)
    decay = np.exp(-T_S / 40.0)
    trace = dict(at_distances(2.0 * decay, 5.0 * decay, 3.0 * decay + 0.01))
    trace["thrust"] = rng.normal(0.0, [[[1.0], [3.0], [2.0]]], (T_S.size, 3, 2))
    summary = metrics.boats(T_S, trace["error"], trace["thrust"], [{}] * 3)
    assert figures.rms_error_m(trace) == pytest.approx(max(b["rms_error_m"] for b in summary))
    assert figures.thrust_rms_N(trace) == pytest.approx(summary[1]["thrust_rms_N"])
    assert figures.thrust_change_N(trace) == pytest.approx(summary[1]["thrust_step_rms_N"])
    assert figures.settling_s(trace) == pytest.approx(40.0 * math.log(100.0), abs=0.1)


def test_settling_time_is_infinite_if_one_boat_never_settles() -> None:
    trace = at_distances(0.0 * T_S, 0.0 * T_S + 0.06)
    assert figures.settling_s(trace) == math.inf


def test_propellers_that_twitch_only_in_the_beginning_are_smooth() -> None:
    trace = dict(at_distances(0.0 * T_S))
    trace["thrust"] = np.zeros((T_S.size, 1, 2))
    trace["thrust"][:1000:2] = 5.0
    assert figures.thrust_change_N(trace) == 0.0
    trace["thrust"][::2, 0, 1] = 0.3
    assert figures.thrust_change_N(trace) == pytest.approx(0.3)


def test_a_far_start_and_a_slow_arrival_are_no_overshoot() -> None:
    away_first = 20.0 + T_S * (T_S < 4.0) - np.clip(T_S / 12.0, 0.0, 20.0)
    assert figures.overshoot_m(at_distances(23.0 * np.exp(-T_S / 20.0), away_first)) == 0.0


def test_boat_that_sails_through_its_slot_overshoots_by_how_far_it_goes_beyond() -> None:
    through = np.abs(20.0 - T_S) * (T_S < 23.55)
    missed_by_1_m = np.hypot(20.0 - T_S, 1.0) * (T_S < 23.55)
    assert figures.overshoot_m(at_distances(0.0 * T_S, through)) == pytest.approx(3.5)
    beside = figures.overshoot_m(at_distances(missed_by_1_m))
    assert beside == pytest.approx(math.hypot(3.5, 1.0) - 1.0)


def test_boat_that_is_never_within_2_m_of_its_slot_has_not_arrived() -> None:
    assert figures.overshoot_m(at_distances(0.0 * T_S, np.hypot(20.0 - T_S, 2.1))) == math.inf


def stop_between(begin_s: float, end_s: float, turned_rad: Array) -> Trace:
    """A leader at rest at first, sailing from 1 s on but in between, and a boat's heading (T)."""
    stopped = (T_S < 1.0) | ((begin_s <= T_S) & (end_s > T_S))
    nu = np.zeros((T_S.size, 2, 3))
    nu[:, 0, 0] = np.where(stopped, 0.04, 0.5)
    eta = np.zeros((T_S.size, 2, 3))
    # unlike a trace's headings these jump, as those of a sensor do
    eta[:, 1, 2] = metrics.wrap(turned_rad)
    return {"t_s": T_S, "nu": nu, "eta": eta}


def test_boat_that_circles_a_stopped_leader_turns_whole_turns() -> None:
    turning = 2.0 * np.pi * T_S / 20.0
    assert figures.turns_at_a_stop(stop_between(100, 160, turning)) == pytest.approx(3, abs=0.01)


def test_boat_that_swings_to_and_fro_does_not_circle() -> None:
    swinging = 1.5 * np.sin(T_S)
    turns = figures.turns_at_a_stop(stop_between(100, 160, swinging))
    assert turns == pytest.approx(3.0 / (2.0 * np.pi), abs=0.01)


def test_turns_while_the_leader_sails_do_not_count_nor_those_before_it_first_sailed() -> None:
    elsewhere = 9.0 * np.clip(T_S, 0.0, 90.0) + 9.0 * np.clip(T_S - 170.0, 0.0, None)
    assert figures.turns_at_a_stop(stop_between(100, 160, elsewhere)) == 0.0


def test_leader_that_stops_to_the_end_of_the_run_counts_and_one_that_never_stops_does_not() -> None:
    turning = 2.0 * np.pi * T_S / 20.0
    assert figures.turns_at_a_stop(stop_between(280, 999, turning)) == pytest.approx(1, abs=0.01)
    assert figures.turns_at_a_stop(stop_between(999, 999, turning)) == math.inf


@pytest.mark.parametrize("until_s", [20, 300])
def test_deviation_is_the_largest_over_all_boats_axes_and_seconds(until_s: int) -> None:
    t_s: Array = 0.5 * np.arange(2 * until_s + 1, dtype=np.float64)
    columns = [[f"ex{i}_m", f"ey{i}_m", f"epsi{i}_rad"] for i in range(1, 5)]
    whole = np.array([[REFERENCE[column] for column in boat] for boat in columns])
    error = np.repeat(np.moveaxis(whole, -1, 0), 2, axis=0)[: t_s.size]
    assert figures.deviation_from_reference({"t_s": t_s, "error": error}) == 0.0
    error[6, 1, 0] -= 0.02
    error[8, 2, 2] += 2.0 * np.pi + 0.01
    error[9] += 7.0  # between two seconds
    deviation = figures.deviation_from_reference({"t_s": t_s, "error": error})
    assert deviation == pytest.approx(0.02)


def under_way(speed_mps: list[float], yaw_rate_radps: list[float], from_s: float) -> Trace:
    """Agents on a line, 3 m apart, each with its speed and yaw rate for 10 s from `from_s` on."""
    now = (from_s <= T_S) & (from_s + 10.0 > T_S)
    nu = np.zeros((T_S.size, len(speed_mps), 3))
    nu[..., 1] = np.where(now[:, None], -np.array(speed_mps), 0.0)
    nu[..., 2] = np.where(now[:, None], -np.array(yaw_rate_radps), 0.0)
    eta = np.zeros((T_S.size, len(speed_mps), 3))
    eta[..., 0] = -3.0 * np.arange(len(speed_mps))
    return {"t_s": T_S, "nu": nu, "eta": eta}


def test_largest_yaw_rate_and_speed_are_those_of_any_boat_and_the_roots_are_its_own() -> None:
    trace = under_way([0.5, 0.6, 1.1, 0.7], [0.3, 0.9, 0.4, 0.8], from_s=200.0)
    assert figures.largest_yaw_rate_radps(trace) == pytest.approx(0.9)
    assert figures.roots_yaw_rate_radps(trace) == pytest.approx(0.3)
    assert figures.largest_speed_mps(trace) == pytest.approx(1.1)
    assert figures.roots_speed_mps(trace) == pytest.approx(0.5)
    assert figures.yaw_rate_growth(trace) == pytest.approx(2.0)


def test_fast_turns_before_100_s_do_not_count_and_a_shorter_run_has_none() -> None:
    trace = under_way([0.5, 0.6], [0.3, 0.9], from_s=80.0)
    assert figures.largest_yaw_rate_radps(trace) == figures.largest_speed_mps(trace) == 0.0
    short = {name: array[:500] for name, array in trace.items()}
    assert figures.largest_yaw_rate_radps(short) == figures.largest_speed_mps(short) == math.inf


def test_least_separation_is_that_of_two_boats_from_100_s_on() -> None:
    trace = under_way([0.5, 0.6, 0.6], [0.3, 0.9, 0.9], from_s=200.0)
    assert figures.least_separation_m(trace) == pytest.approx(3.0)
    trace["eta"][T_S < 99.0, 1] = trace["eta"][T_S < 99.0, 2]
    assert figures.least_separation_m(trace) == pytest.approx(3.0)
    trace["eta"][2000, 1, 0] = -5.5
    assert figures.least_separation_m(trace) == pytest.approx(0.5)
