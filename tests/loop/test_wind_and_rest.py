# SPDX-License-Identifier: MIT
"""Boats before a strong wind, and boats whose leader rests."""

import numpy as np
import pytest

from sil.lockstep import metrics
from sil.report import figures
from tests.loop.conftest import Sail


@pytest.mark.parametrize("wind_mps", [12.0, 15.0])
def test_before_a_strong_wind_slow_boats_come_to_their_track(sail: Sail, wind_mps: float) -> None:
    run = sail("tail_wind", "duration_s=150", f"wind.mean_mps=[{wind_mps}, 0.0]")
    assert figures.rms_error_m(run.trace) < 0.05


def test_boats_abeam_of_a_resting_leader_form_up_and_lie_still(sail: Sail) -> None:
    trace = sail("resting_leader", "duration_s=150").trace
    late = trace["t_s"] >= 60.0
    assert (metrics.distances(trace["error"])[0] >= 10.0).all()
    assert metrics.distances(trace["error"])[late].max() < 0.4
    # the leader's heading, and nobody hunts
    assert np.abs(trace["error"][late, :, 2]).max() < 0.05
    assert np.ptp(np.unwrap(trace["eta"][..., 2], axis=0), axis=0).max() < 2.0 * np.pi


@pytest.mark.parametrize("current_mps", [[0.0, 0.1], [0.1, 0.0], [-0.1, -0.1]])
def test_boats_beside_a_resting_leader_do_not_circle_in_a_current(
    sail: Sail, current_mps: list[float]
) -> None:
    trace = sail("resting_leader", "duration_s=200", f"water.current_mps={current_mps}").trace
    assert figures.rms_error_m(trace) < 0.2
    late = trace["t_s"] >= 120.0
    assert np.ptp(np.unwrap(trace["eta"][late, 1:, 2], axis=0), axis=0).max() < 0.5


def test_when_the_leader_stops_boats_in_formation_stay_as_they_are(sail: Sail) -> None:
    trace = sail("stop_and_go", "duration_s=90").trace
    assert figures.turns_at_a_stop(trace) < 0.1
    assert figures.overshoot_m(trace) < 0.14
