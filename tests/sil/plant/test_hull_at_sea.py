# SPDX-License-Identifier: MIT
"""Hulls with more terms than the paper's, in a current, against matrices and integrals."""

from dataclasses import astuple

import numpy as np
import pytest
from scipy.integrate import quad, solve_ivp

from sil.plant import hull
from sil.plant.hull import Array, HullParameters

PAPER = HullParameters(m11=1.012, m22=1.982, m33=0.354, d11=3.436, d22=18.99, d33=0.864)
SEA = HullParameters(
    m11=85.0,
    m22=162.0,
    m33=41.0,
    d11=39.0,
    d22=120.0,
    d33=41.0,
    m23=11.0,
    d11_quadratic=12.5,
    d33_quadratic=400.0,
    crossflow=100.0,
    length_m=2.0,
    d33_speed=60.0,
)
CURRENT = np.array([[0.12, -0.3]])
START = np.array([[3.0, -2.0, 0.7, 0.9, -0.3, 0.25]])
PUSH = np.array([[4.0, -6.0, 1.5]])


def sail(p: HullParameters, current: Array, duration_s: float, tau: Array, h_s: float) -> Array:
    """Pose and velocity (6) at the end, from START under `tau` (2) and PUSH in proportion."""
    eta, nu = START[:, :3].copy(), START[:, 3:].copy()
    held = np.tile(tau, (3, 1, 1))
    for _ in range(round(duration_s / h_s)):
        hull.advance(eta, nu, held, PUSH * p.m11 / 85.0, current, hull.stack([p]), h_s)
    return np.hstack([eta, nu])[0]


def drag_of(p: HullParameters, nu_r: Array) -> Array:
    """[X Y N] of all damping: the cross-flow strip by strip, by adaptive quadrature."""
    u, v, r = nu_r
    linear = np.array([p.d11 * u, p.d22 * v, p.d33 * r])
    quadratic = np.array(
        [
            p.d11_quadratic * abs(u) * u,
            0.0,
            (p.d33_quadratic * abs(r) + p.d33_speed * abs(u)) * r,
        ]
    )
    half, kink = 0.5 * p.length_m, [] if r == 0.0 else [-v / r]
    inside = [x for x in kink if abs(x) < half]

    def strip(x: float, lever: int) -> float:
        return float(x**lever * abs(v + x * r) * (v + x * r))

    sway, yaw = (
        quad(strip, -half, half, args=(lever,), points=inside or None)[0] for lever in (0, 1)
    )
    return linear + quadratic + p.crossflow * np.array([0.0, sway, yaw])


def exact(p: HullParameters, current: Array, duration_s: float, tau: Array) -> Array:
    """The same from ν_r as the state, M ν̇_r = τ + w − C(ν_r) ν_r − D ν_r, η̇ = R ν_r + c."""
    mass = np.diag([p.m11, p.m22, p.m33])
    mass[1, 2] = mass[2, 1] = p.m23
    force = np.array([tau[0], 0.0, tau[1]]) + PUSH[0] * p.m11 / 85.0

    def rotation(psi: float) -> Array:
        return np.array(
            [[np.cos(psi), -np.sin(psi), 0.0], [np.sin(psi), np.cos(psi), 0.0], [0.0, 0.0, 1.0]]
        )

    def rates(_: float, state: Array) -> Array:
        nu_r = state[3:]
        momentum = mass @ nu_r
        gyric = np.array(
            [[0, 0, -momentum[1]], [0, 0, momentum[0]], [momentum[1], -momentum[0], 0]]
        )
        accel = np.linalg.solve(mass, force - gyric @ nu_r - drag_of(p, nu_r))
        return np.concatenate([rotation(state[2]) @ nu_r + [*current[0], 0.0], accel])

    water = rotation(START[0, 2]).T @ np.array([*current[0], 0.0])
    initial = np.concatenate([START[0, :3], START[0, 3:] - water])
    run = solve_ivp(rates, (0.0, duration_s), initial, "DOP853", rtol=1e-10, atol=1e-11)
    end = run.y[:, -1]
    over_ground = end[3:] + rotation(end[2]).T @ np.array([*current[0], 0.0])
    return np.concatenate([end[:3], over_ground])


@pytest.mark.parametrize(
    ("parameters", "tau"),
    [(PAPER, [2.0, 0.2]), (SEA, [60.0, 8.0]), (SEA, [0.0, 40.0]), (SEA, [-30.0, -5.0])],
)
def test_boat_in_a_current_sails_as_the_adaptive_integrator_says(
    parameters: HullParameters, tau: list[float]
) -> None:
    sailed = sail(parameters, CURRENT, 10.0, np.array(tau), 0.005)
    expected = exact(parameters, CURRENT, 10.0, np.array(tau))
    # the cross-flow has a kink where it turns, where Runge-Kutta is of second order
    np.testing.assert_allclose(sailed, expected, rtol=0.0, atol=2e-6)


@pytest.mark.parametrize("v", [-0.7, -1e-9, 0.0, 0.2, 0.3])
@pytest.mark.parametrize("r", [-2.0, -0.2, 0.0, 1e-12, 0.3])
def test_crossflow_is_the_integral_along_the_waterline(v: float, r: float) -> None:
    heavy = HullParameters(1e3, 1e3, 1e3, 0, 0, 0, crossflow=100.0, length_m=2.0)
    _, *expected = drag_of(heavy, np.array([0.0, v, r]))
    nu, none, step_s = np.array([[0.0, v, r]]), np.zeros((1, 3)), 1e-6
    still = np.zeros((1, 2))
    hull.advance(none.copy(), nu, np.zeros((3, 1, 2)), none, still, hull.stack([heavy]), step_s)
    drag = -1e3 * (nu[0, 1:] - [v, r]) / step_s
    np.testing.assert_allclose(drag, expected, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("parameters", [PAPER, SEA])
def test_boat_without_thrust_ends_up_moving_with_the_water(parameters: HullParameters) -> None:
    eta, nu = START[:, :3].copy(), np.zeros((1, 3))
    idle, free = np.zeros((3, 1, 2)), np.zeros((1, 3))
    for _ in range(12_000):
        hull.advance(eta, nu, idle, free, CURRENT, hull.stack([parameters]), 0.01)
    cos, sin = np.cos(eta[0, 2]), np.sin(eta[0, 2])
    drift = [cos * nu[0, 0] - sin * nu[0, 1], sin * nu[0, 0] + cos * nu[0, 1]]
    np.testing.assert_allclose(drift, CURRENT[0], atol=1e-4)
    assert abs(nu[0, 2]) < 1e-4


def test_a_current_moves_a_boat_as_a_moving_frame_does() -> None:
    """Galilean invariance: relative to the water, the boat moves as in still water."""
    h_s, tau = 0.01, np.tile([60.0, 8.0], (3, 1, 1))
    parameters, free = hull.stack([SEA]), np.zeros((1, 3))
    seen, still = START[:, :3].copy(), START[:, :3].copy()
    nu_still = START[:, 3:].copy()
    cos, sin = np.cos(START[0, 2]), np.sin(START[0, 2])
    north, east = CURRENT[0]
    nu_seen = nu_still + np.array([cos * north + sin * east, cos * east - sin * north, 0.0])
    for _ in range(2000):
        hull.advance(seen, nu_seen, tau, free, CURRENT, parameters, h_s)
        hull.advance(still, nu_still, tau, free, np.zeros((1, 2)), parameters, h_s)
    drifted = still + 20.0 * np.array([north, east, 0.0])
    np.testing.assert_allclose(seen, drifted, atol=1e-6)


def test_drifting_sea_hull_loses_energy_at_the_rate_of_its_drag() -> None:
    mass = np.diag([SEA.m11, SEA.m22, SEA.m33])
    mass[1, 2] = mass[2, 1] = SEA.m23
    rng = np.random.default_rng(5)
    for _ in range(200):
        eta, nu = np.zeros((1, 3)), rng.normal(size=(1, 3)) * [2.0, 1.0, 1.0]
        before = nu[0].copy()
        idle = np.zeros((3, 1, 2))
        hull.advance(eta, nu, idle, np.zeros((1, 3)), np.zeros((1, 2)), hull.stack([SEA]), 1e-4)
        gained = 0.5 * (nu[0] @ mass @ nu[0] - before @ mass @ before)
        middle = 0.5 * (before + nu[0])
        assert gained < 0.0
        assert gained == pytest.approx(-1e-4 * middle @ drag_of(SEA, middle), rel=1e-4)


def test_hull_without_valid_inertia_is_refused() -> None:
    with pytest.raises(ValueError, match="m23 = 90"):
        hull.stack([HullParameters(85, 162, 41, 1, 1, 1, m23=90.0)])


def test_mismatch_is_uniform_within_its_bounds_and_repeats_with_its_seed() -> None:
    rng = np.random.default_rng(1)
    boats = [hull.mismatched(SEA, 0.5, rng) for _ in range(2000)]
    factors = np.array([astuple(boat)[:6] for boat in boats]) / astuple(SEA)[:6]
    assert factors.min() >= 0.5 and factors.max() <= 1.5
    np.testing.assert_allclose(factors.mean(axis=0), 1.0, atol=0.02)
    np.testing.assert_allclose(factors.std(axis=0), 1.0 / np.sqrt(12.0), rtol=0.03)
    shared = np.corrcoef(factors.T) - np.eye(6)
    assert np.abs(shared).max() < 0.08, "parameters are drawn one by one"
    assert {astuple(boat)[6:] for boat in boats} == {astuple(SEA)[6:]}
    assert hull.mismatched(SEA, 0.5, np.random.default_rng(1)) == boats[0]
