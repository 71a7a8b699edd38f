# SPDX-License-Identifier: MIT
"""A hull of the simulation's physics is found again in its log, with honest intervals."""

import json
import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from sil.certificate import one_hull
from sil.identify import identify_files
from sil.identify.hull_terms import INDEX, TERMS
from sil.identify.identification import Identification, identify
from sil.identify.identify_report import holds, lacking
from sil.identify.vessel_numbers import Boat, drag_N, hull_of, parameters, yaw_moment_Nm
from sil.identify.voyage_log import SAMPLE_S
from sil.identify.voyage_model import Body, simulate, static_thrust
from tests.sil.identify.sailed import HULL, PROPELLERS, levels, sail

BODY = Body(arm_m=0.28, length_m=1.2, h_s=SAMPLE_S)
BOAT = Boat(mass_kg=HULL.m11 / 1.05)


@cache
def found() -> Identification:
    rng = np.random.default_rng(5)
    log = sail(levels(rng, 260.0), rng, current=(0.08, -0.05))
    return identify([log], BODY, lambda _: None)


def near(value: float, true: float, share: float) -> None:
    print(f"{value:.4g}, in truth {true:.4g}")
    assert value == pytest.approx(true, rel=share)


def test_drag_ahead_is_found() -> None:
    for u in (0.5, 1.0):
        true = HULL.d11 * u + HULL.d11_quadratic * u * u
        near(float(drag_N(found().fit.values, HULL.m11, u)), true, 0.05)


def test_the_drag_is_the_thrust_that_holds_the_speed_in_calm() -> None:
    terms = np.array([term.guess for term in TERMS])
    terms[INDEX["wind_x"]] = 0.1
    commands = np.full((400, 1, 2), 0.6)
    out = simulate(terms[:, None], np.zeros((8, 1, 1)), np.zeros((6, 1, 1)), commands, BODY)
    u = float(out[-1, 3, 0, 0])
    assert u > 0.5 and u == pytest.approx(float(out[-20, 3, 0, 0]), rel=1e-4)
    thrust = static_thrust(terms[:, None], commands[0, 0], BODY.gate).sum()
    assert float(drag_N(terms, 1.0, u)) == pytest.approx(thrust, rel=1e-3)


def test_the_hulls_file_has_the_drag_that_is_reported() -> None:
    hull = hull_of(found(), BOAT).vessel
    told = (hull.d11 + hull.d11_quadratic * 1.5) * 1.5
    assert told == pytest.approx(float(drag_N(found().fit.values, BOAT.surge_mass_kg, 1.5)))


def test_yaw_damping_is_found() -> None:
    for r in (0.1, 0.3):
        true = HULL.d33 * r + HULL.d33_quadratic * r * r
        near(float(yaw_moment_Nm(found().fit.values, HULL.m11, r, 1.2)), true, 0.05)


def test_inertias_are_found_as_ratios() -> None:
    terms = found().fit.values
    near(terms[INDEX["m22"]], HULL.m22 / HULL.m11, 0.1)
    near(terms[INDEX["m33"]], HULL.m33 / HULL.m11, 0.05)


def test_the_stronger_propeller_and_the_lag_are_found() -> None:
    terms = found().fit.values
    assert terms[INDEX["gain"]] == pytest.approx(0.05, abs=0.01)
    late = terms[INDEX["lag"]] + terms[INDEX["dead_time"]]
    assert late == pytest.approx(PROPELLERS.lag_s, abs=0.03)


def test_the_current_is_found() -> None:
    assert found().fit.local[0, :2] == pytest.approx((0.08, -0.05), abs=0.02)


def test_intervals_contain_the_true_values() -> None:
    truth = {"m33": HULL.m33 / HULL.m11, "gain": 0.05, "forward": 35.0 / HULL.m11, "expo": 0.4}
    for name, true in truth.items():
        low, high = found().intervals.of(found().intervals.draws[:, INDEX[name]])
        print(name, low, true, high)
        assert low < true < high


def test_the_half_that_was_not_fitted_is_predicted() -> None:
    assert holds(found())
    for score in found().held_out:
        assert score is not None
        print(score)
        assert min(score.u, score.r) > 0.97 and score.v > 0.9


def test_parameters_are_those_of_the_simulated_boat() -> None:
    values = parameters(found(), BOAT)
    near(values["VES_M11"], HULL.m11, 1e-4)
    near(values["THR_FWD_MAX"], 35.0, 0.05)
    near(values["THR_REV_MAX"], 20.0, 0.05)
    assert values["THR_BALANCE"] == pytest.approx(0.05, abs=0.01)
    assert values["THR_LAG"] == pytest.approx(PROPELLERS.lag_s, abs=0.03)
    assert "THR_PORT_DIR" not in values
    # in the log the antenna is on the reference point
    assert abs(values["NAV_OFS_X"]) < 0.1 and abs(values["NAV_OFS_Y"]) < 0.1
    assert "NAV_LAG_S" not in values


def test_page_reports_whether_the_gains_fit(tmp_path: Path) -> None:
    names = {path.name for path in identify_files.write_hull(found(), BOAT, tmp_path)}
    assert names == {"hull.param", "hull.params", "hull.toml"}
    for fitting, told in ((True, "derives fit this hull: certified"), (False, "do not fit")):
        fit = (fitting, "certified" if fitting else "not certified")
        identify_files.write(found(), BOAT, fit, tmp_path)
        page = " ".join((tmp_path / "identify.html").read_text(encoding="utf-8").split())
        assert told in re.sub("<[^>]*>", "", page)
        written = json.loads((tmp_path / "identify.json").read_text(encoding="utf-8"))
        assert written["gains"] == {"fit": fitting, "verdict": fit[1]}


def test_gains_that_are_derived_fit_the_hull_that_was_found(tmp_path: Path) -> None:
    identify_files.write_hull(found(), BOAT, tmp_path)
    fitting, told = one_hull.fits(tmp_path / "hull.toml", {}, lambda *_: None)
    assert fitting and told.startswith("certified about the formation"), told
    fitting, told = one_hull.fits(tmp_path / "hull.toml", {"THR_FWD_MAX": 3.0}, lambda *_: None)
    assert not fitting and told.startswith("not certified"), told


@pytest.mark.nightly
def test_a_gain_that_is_far_too_high_does_not_fit_the_hull_that_was_found(tmp_path: Path) -> None:
    identify_files.write_hull(found(), BOAT, tmp_path)
    fitting, told = one_hull.fits(tmp_path / "hull.toml", {"LAW_KDR": 9000.0}, lambda *_: None)
    assert not fitting and told.startswith("not certified"), told


def test_a_boat_that_never_went_astern_does_not_know_its_thrust_astern() -> None:
    rng = np.random.default_rng(6)
    commands = np.maximum(levels(rng, 200.0), 0.0)
    told = " ".join(lacking(identify([sail(commands, rng)], BODY, lambda _: None)))
    print(told)
    assert "thrust full astern" in told and "each propeller alone, ahead and astern" in told
    assert "drag ahead" not in told and "yaw damping" not in told
