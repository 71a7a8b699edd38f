# SPDX-License-Identifier: MIT
"""The named hulls: where each number is from, and what the firmware is told of them."""

import tomllib

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq

from sil.examine.scenario_page import meanings
from sil.plant import hull
from sil.plant.hull import Array
from sil.scenario import presets

NAMES = presets.names()


@pytest.mark.parametrize("name", NAMES)
def test_every_number_has_a_source_or_is_called_an_estimate(name: str) -> None:
    text = presets.path_of(name).read_text(encoding="utf-8")
    document, said = tomllib.loads(text), meanings(text)
    for table in ("cruise", "vessel", "propellers"):
        for key in document[table]:
            first = said[table, key].replace(",", ":").partition(":")[0]
            assert first in {*document["sources"], "estimate"}, (name, table, key)


def skew(a: list[float]) -> Array:
    """S(a) b = a × b."""
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def test_otter_is_otter_m() -> None:
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
    assert model.d11 * u == pytest.approx(p.d11 * u + p.d11_quadratic * u**2)
    assert model.d22 * v == pytest.approx(p.d22 * v + drag(v, 0), rel=1e-3)
    yaw = (p.d33 + p.d33_speed * u + p.d33_quadratic * r) * r + drag(v, 1)
    assert model.d33 * r == pytest.approx(yaw, rel=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_hull_at_cruise_keeps_its_speed_with_the_thrust_that_the_firmware_believes(
    name: str,
) -> None:
    preset = presets.load(name)
    speed = preset.cruise.speed_mps
    eta, nu = np.zeros((1, 3)), np.array([[speed, 0.0, 0.0]])
    tau = np.tile([presets.linear(preset).d11 * speed, 0.0], (3, 1, 1))
    still = np.zeros((1, 3)), np.zeros((1, 2)), hull.stack([preset.vessel.hull])
    for _ in range(1000):
        hull.advance(eta, nu, tau, *still, 0.01)
    assert nu[0] == pytest.approx([speed, 0.0, 0.0], abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(("axis", "zeta"), [("u", 1.0853), ("r", 0.7023)])
def test_velocity_loops_have_the_damping_of_the_papers(name: str, axis: str, zeta: float) -> None:
    preset = presets.load(name)
    model, own = presets.linear(preset), presets.firmware(preset)
    m, d, k = {
        "u": (model.m11, model.d11, own["LAW_KDU"]),
        "r": (model.m33, model.d33, own["LAW_KDR"]),
    }[axis]
    lag = preset.propellers.lag_s + 0.018
    poles = np.roots([m * lag, m + d * lag, d + k])
    assert -poles.sum().real / (2 * np.sqrt(poles.prod().real)) == pytest.approx(zeta, rel=1e-3)


@pytest.mark.parametrize("name", NAMES)
def test_propellers_hold_the_greatest_yaw_rate_at_cruise(name: str) -> None:
    preset = presets.load(name)
    own, pair = presets.firmware(preset), preset.propellers
    p, u = preset.vessel.hull, preset.cruise.speed_mps
    moment = pair.arm_m * (pair.forward_max_N + pair.reverse_max_N)
    half = 0.5 * p.length_m

    def turning(_: float, r: Array) -> Array:
        swing = quad(lambda x: x * abs(x * r[0]) * x * r[0], -half, half)[0]
        damping = (p.d33 + p.d33_speed * u + p.d33_quadratic * abs(r[0])) * r[0]
        return np.array([(moment - damping - p.crossflow * swing) / p.m33])

    end = solve_ivp(turning, (0.0, 200.0), [0.0], rtol=1e-8).y[0, -1]
    assert own["LAW_R_MAX"] < end
    assert own["LAW_R_MAX"] == pytest.approx(0.8) or own["LAW_R_MAX"] > 0.85 * end
