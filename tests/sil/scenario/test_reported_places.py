# SPDX-License-Identifier: MIT
"""Boats' positions in the coordinates that their units send."""

import math
from typing import Any

import numpy as np
import pytest

from sil.scenario.reported_places import Told
from sil.scenario.wiring import ORIGIN
from sil.wire.navigation_unit import Settings

ETA = np.array([[10.0, -20.0, 0.5], [1000.0, 500.0, -2.0], [-300.0, 40.0, 3.0]])
LOCAL = Settings(100.0)


def test_units_in_the_worlds_frame_report_the_poses_of_the_world() -> None:
    told = Told([LOCAL, Settings(10.0, "odometry"), LOCAL])
    assert told.poses(ETA) is ETA
    assert told.degE7 is None and told.origins == [ORIGIN] * 3


def test_a_unit_with_its_own_origin_reports_positions_relative_to_it() -> None:
    told = Told([LOCAL, LOCAL._replace(origin_m=(900.0, 450.0)), LOCAL])
    eta = told.poses(ETA)
    assert (eta[[0, 2]] == ETA[[0, 2]]).all()
    np.testing.assert_allclose(eta[1], [100.0, 50.0, -2.0], atol=0.05)
    latitude, longitude, altitude = told.origins[1]
    assert (latitude - ORIGIN[0]) * 1e-7 * 111_200 == pytest.approx(900.0, rel=1e-3)
    assert longitude > ORIGIN[1] and altitude == ORIGIN[2]


@pytest.mark.parametrize("message", ["global", "follow_target"])
def test_a_global_unit_reports_latitude_longitude_and_true_heading(message: Any) -> None:
    told = Told([LOCAL, Settings(10.0, message), LOCAL])
    for shift_m in (0.0, 111.3):
        eta = ETA + np.array([shift_m, 0.0, 0.0])
        poses = told.poses(eta)
        assert (poses[[0, 2]] == eta[[0, 2]]).all() and (poses[1, :2] == eta[1, :2]).all()
        assert poses[1, 2] == pytest.approx(-2.0, abs=1e-3) and poses[1, 2] != -2.0
        assert told.degE7 is not None
        latitude, longitude = (told.degE7[1] - ORIGIN[:2]) * 1e-7
        assert latitude * 111_200.0 == pytest.approx(1000.0 + shift_m, rel=1e-3)
        across_m = 111_320.0 * math.cos(math.radians(48.7))
        assert longitude * across_m == pytest.approx(500.0, rel=3e-3)


@pytest.mark.parametrize("lost", [math.nan, math.inf, -1e300, 2e7])
@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_boat_beyond_the_globe_keeps_its_last_reported_position(lost: float, axis: int) -> None:
    told = Told([LOCAL, Settings(10.0, "global"), Settings(10.0, "follow_target")])
    psi = told.poses(ETA)[:, 2].copy()
    assert told.degE7 is not None
    places = told.degE7.copy()
    eta = ETA + 1.0
    eta[1, axis] = lost
    assert told.poses(eta)[1, 2] == psi[1] and told.poses(eta)[2, 2] != psi[2]
    assert (told.degE7[1] == places[1]).all() and (told.degE7[2] != places[2]).all()
    assert (told.poses(ETA + 1.0)[1:, 2] != psi[1:]).all()
    assert (told.degE7 != places)[1:].all()
