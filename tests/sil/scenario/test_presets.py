# SPDX-License-Identifier: MIT
"""The named hulls: where each number is from, and what the firmware is told of them."""

import tomllib
from pathlib import Path

import flotilla
import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from sil.certificate.certified_fleet import parameters as certified
from sil.examine.scenario_page import meanings
from sil.plant import hull
from sil.plant.hull import Array
from sil.scenario import presets
from sil.scenario.scenario import load
from sil.scenario.toml_errors import ScenarioError

NAMES = presets.names()


@pytest.mark.parametrize("name", NAMES)
def test_every_number_has_a_source_or_is_called_an_estimate(name: str) -> None:
    text = presets.path_of(name).read_text(encoding="utf-8")
    document, said = tomllib.loads(text), meanings(text)
    for table in ("cruise", "vessel", "propellers"):
        for key in document[table]:
            first = said[table, key].replace(",", ":").partition(":")[0]
            assert first in {*document["sources"], "estimate"}, (name, table, key)


@pytest.mark.parametrize(
    ("line", "new", "told"),
    [
        ("m11 = ", "", '[0-9]+: missing key "vessel.m11"'),
        ("arm_m = ", "", '[0-9]+: missing key "propellers.arm_m"'),
        ("m11 = ", "m11 = nan", '13: "vessel.m11" = NaN: must be a finite number'),
        ("m11 = ", "m11 = -1", '13: "vessel.m11" = -1: must be greater than 0'),
        ("m11 = ", "m12 = 1", '13: unknown key "vessel.m12"'),
        ("m11 = ", "m22 = 1", "14: not TOML: Cannot overwrite a value"),
        ("[propellers]", "[propeler]", 'missing key "propellers"'),
    ],
)
def test_mistake_in_a_hulls_file_is_reported_by_line_and_key(
    tmp_path: Path, line: str, new: str, told: str
) -> None:
    text = presets.path_of("paper").read_text(encoding="utf-8").splitlines()
    (at,) = [k for k, row in enumerate(text) if row.startswith(line)]
    path = tmp_path / "mine.toml"
    path.write_text("\n".join([*text[:at], new, *text[at + 1 :]]), encoding="utf-8")
    with pytest.raises(ScenarioError, match=rf"mine\.toml:.*{told}") as error:
        presets.load(str(path))
    assert "pydantic" not in str(error.value)


def skew(a: list[float]) -> Array:
    """S(a) b = a × b."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def test_otter_has_the_values_of_fossens_otter_m() -> None:
    """Fossen's computation, written again from his equations."""
    rho, g, L, m, mp = 1025.0, 9.81, 2.0, 55.0, 25.0
    rg = (m * np.array([0.2, 0.0, -0.2]) + mp * np.array([0.0, 0.0, -0.35])) / (m + mp)
    inertia = m * np.diag([(0.4 * 1.08) ** 2, (0.25 * L) ** 2, (0.25 * L) ** 2])
    inertia = inertia - m * skew(list(rg)) @ skew(list(rg))
    inertia = inertia - mp * skew([0.0, 0.0, -0.35]) @ skew([0.0, 0.0, -0.35])
    rigid = np.zeros((6, 6))
    rigid[:3, :3], rigid[3:, 3:] = (m + mp) * np.eye(3), inertia
    carry = np.eye(6)
    carry[:3, 3:] = skew(list(rg)).T
    M = carry.T @ rigid @ carry
    added = [2.7 * rho * (m / rho) ** (5 / 3) / L**2, 1.5 * m, 0, 0, 0, 1.7 * inertia[2, 2]]
    M += np.diag(added)
    otter = presets.load("otter")
    vessel, pair = otter.vessel, otter.propellers
    wanted = [M[0, 0], M[1, 1], M[5, 5], M[1, 5]]
    assert [vessel.m11, vessel.m22, vessel.m33, vessel.m23] == pytest.approx(wanted, rel=1e-3)
    assert [vessel.d22, vessel.d33] == pytest.approx([M[1, 1], M[5, 5]], rel=1e-3)
    assert vessel.d33_quadratic == pytest.approx(10 * M[5, 5], rel=1e-3)
    top = 6 * 0.5144
    both = (vessel.d11 + vessel.d11_quadratic * top) * top
    assert both == pytest.approx(24.4 * g, rel=1e-3)
    assert 2 * pair.forward_max_N == pytest.approx(24.4 * g, rel=1e-3)
    assert 2 * pair.reverse_max_N == pytest.approx(13.6 * g, rel=1e-3)
    draught = (m + mp) / rho / (2 * 0.4 * 0.25 * L)
    assert vessel.draft_m == pytest.approx(draught, rel=2e-3)


@pytest.mark.parametrize("name", NAMES)
def test_firmwares_drag_is_the_hulls_in_a_steady_turn_at_cruise(name: str) -> None:
    preset = presets.load(name)
    p, model = preset.vessel.hull, presets.linear(preset)
    u, r = preset.cruise.speed_mps, preset.cruise.yaw_rate_radps
    half = 0.5 * p.length_m

    def drag(v: float, lever: int) -> float:
        kinks = [x for x in [-v / r] if abs(x) < half]
        flow = quad(
            lambda x: x**lever * abs(v + x * r) * (v + x * r), -half, half, points=kinks or None
        )
        return float(p.crossflow * flow[0])

    v = brentq(lambda v: p.m11 * u * r + p.d22 * v + drag(v, 0), -5.0, 0.0)
    ahead = (model.d11 + model.d11_quadratic * u) * u
    assert ahead == pytest.approx(p.d11 * u + p.d11_quadratic * u**2)
    assert model.d22 * v == pytest.approx(p.d22 * v + drag(v, 0), rel=1e-3)
    yaw = (p.d33 + p.d33_speed * u + p.d33_quadratic * r) * r + drag(v, 1)
    assert (model.d33 + model.d33_speed * u) * r == pytest.approx(yaw, rel=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_hull_at_cruise_keeps_its_speed_with_the_thrust_that_the_firmware_believes(
    name: str,
) -> None:
    preset = presets.load(name)
    speed, own = preset.cruise.speed_mps, presets.firmware(preset)
    eta, nu = np.zeros((1, 3)), np.array([[speed, 0.0, 0.0]])
    thrust_N = (own["VES_D11"] + own["VES_D11Q"] * speed) * speed
    tau = np.tile([thrust_N, 0.0], (3, 1, 1))
    still = np.zeros((1, 3)), np.zeros((1, 2)), hull.stack([preset.vessel.hull])
    for _ in range(1000):
        hull.advance(eta, nu, tau, *still, 0.01)
    assert nu[0] == pytest.approx([speed, 0.0, 0.0], rel=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_every_gain_is_derived_by_the_firmware(name: str) -> None:
    own = presets.firmware(presets.load(name))
    told = {parameter: value for parameter, value in own.items() if parameter.startswith("LAW_")}
    assert told == dict.fromkeys(presets.DERIVED, -1.0)
    gains = flotilla.derived(own)
    assert all(gains[parameter] > 0.0 for parameter in told)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("axis", "least"), [("u", 0.95), ("r", 0.65)])
def test_derived_velocity_loops_are_damped_as_the_papers_are(
    name: str, axis: str, least: float
) -> None:
    preset = presets.load(name)
    gains = flotilla.derived(presets.firmware(preset))
    hull, speed = preset.vessel.hull, preset.cruise.speed_mps
    m, d, k = {
        "u": (hull.m11, hull.d11 + hull.d11_quadratic * speed, gains["LAW_KDU"]),
        "r": (hull.m33, hull.d33 + hull.d33_speed * speed, gains["LAW_KDR"]),
    }[axis]
    lag = preset.propellers.lag_s + 0.018
    poles = np.roots([m * lag, m + d * lag, d + k])
    assert least < -poles.sum().real / (2 * np.sqrt(poles.prod().real)) < 1.4


@pytest.mark.parametrize("name", NAMES)
def test_lateral_loop_is_damped_at_the_greatest_speed(name: str) -> None:
    """T_r ÿ + ẏ + y u/Δ = 0, T_r from the gain itself."""
    preset = presets.load(name)
    gains = flotilla.derived(presets.firmware(preset))
    lag_s = gains["VES_M33"] / (gains["LAW_KDR"] + gains["VES_D33"])
    zeta = 0.5 * np.sqrt(gains["LAW_XT_DIST"] / (gains["LAW_U_MAX"] * lag_s))
    assert zeta > 0.7
    length_m = preset.vessel.length_m or 1.3
    assert gains["LAW_XT_DIST"] <= max(length_m / 1.3, 1.0) + 1e-6


@pytest.mark.parametrize("name", NAMES)
def test_fleet_sails_with_the_gains_of_the_rule(name: str) -> None:
    fleet = load("diamond", [f"hull={name}", "law=product"])
    (own, *_) = certified(fleet, {})
    wanted = flotilla.derived(presets.firmware(presets.load(name)))
    assert {gain: own[gain] for gain in presets.DERIVED} == pytest.approx(
        {gain: wanted[gain] for gain in presets.DERIVED}
    )
