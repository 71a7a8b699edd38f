# SPDX-License-Identifier: MIT
"""Hulls against an adaptive 8th-order solution, the reference run and their own physics."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sil.plant import hull
from sil.plant.hull import Array, HullParameters
from sil.report.figures import REFERENCE

NOMINAL = HullParameters(m11=1.012, m22=1.982, m33=0.354, d11=3.436, d22=18.99, d33=0.864)
LIGHT = HullParameters(m11=0.6, m22=1.1, m33=0.2, d11=2.0, d22=8.0, d33=0.5)

START = np.array([[1.46, 0.45, 1.33], [-3.45, 2.25, 1.02]])
SPEED = np.array([[0.5, 0.1, -0.3], [0.2, -0.1, 0.4]])
STILL = np.zeros((2, 2))
DISTURBANCE = np.array([[0.3, -0.2, 0.05], [-0.1, 0.4, -0.02]])


def leader_input(t_s: float) -> Array:
    return np.array([2.0, 0.3 * np.sin(0.3 * t_s)])


def sail(h_s: float, duration_s: float, start: Array, speed: Array, w: Array) -> Array:
    """Poses and velocities (n, 6) at the end; all vessels get the virtual leader's input."""
    eta, nu, n = start.copy(), speed.copy(), len(start)
    parameters = hull.stack([NOMINAL, LIGHT][:n])
    for k in range(round(duration_s / h_s)):
        times = [k * h_s, (k + 0.5) * h_s, (k + 1) * h_s]
        tau = np.array([[leader_input(t)] * n for t in times])
        hull.advance(eta, nu, tau, w, STILL[: len(eta)], parameters, h_s)
    return np.hstack([eta, nu])


def exact(p: HullParameters, duration_s: float, start: Array, speed: Array, w: Array) -> Array:
    """The same from matrices, M ν̇ = τ + w − C ν − D ν, with an adaptive integrator."""
    mass, drag = np.diag([p.m11, p.m22, p.m33]), np.diag([p.d11, p.d22, p.d33])

    def rates(t: float, state: Array) -> Array:
        psi, nu = state[2], state[3:]
        momentum = mass @ nu
        coriolis = np.zeros((3, 3))
        coriolis[:2, 2] = -momentum[1], momentum[0]
        coriolis[2, :2] = momentum[1], -momentum[0]
        surge, yaw = leader_input(t)
        force = np.array([surge, 0.0, yaw]) + w - coriolis @ nu - drag @ nu
        rotation = np.array(
            [[np.cos(psi), -np.sin(psi), 0.0], [np.sin(psi), np.cos(psi), 0.0], [0.0, 0.0, 1.0]]
        )
        return np.concatenate([rotation @ nu, np.linalg.solve(mass, force)])

    initial = np.concatenate([start, speed])
    solution = solve_ivp(rates, (0.0, duration_s), initial, "DOP853", rtol=1e-12, atol=1e-12)
    return np.asarray(solution.y[:, -1])


def test_two_different_boats_sail_as_the_adaptive_integrator_says() -> None:
    sailed = sail(0.01, 20.0, START, SPEED, DISTURBANCE)
    for i, parameters in enumerate((NOMINAL, LIGHT)):
        expected = exact(parameters, 20.0, START[i], SPEED[i], DISTURBANCE[i])
        np.testing.assert_allclose(sailed[i], expected, rtol=0.0, atol=1e-7)


def test_the_integration_error_is_of_fourth_order() -> None:
    expected = exact(NOMINAL, 4.0, START[0], SPEED[0], DISTURBANCE[0])
    errors = [
        np.linalg.norm(sail(h, 4.0, START[:1], SPEED[:1], DISTURBANCE[:1])[0] - expected)
        for h in (0.04, 0.02, 0.01)
    ]
    np.testing.assert_allclose(np.log2([errors[0] / errors[1], errors[1] / errors[2]]), 4, atol=0.2)


def test_virtual_leader_sails_the_path_of_the_reference_run() -> None:
    reference = np.genfromtxt(REFERENCE, delimiter=",", names=True)
    eta, nu = np.zeros((1, 3)), np.zeros((1, 3))
    parameters, w, poses = hull.stack([NOMINAL]), np.zeros((1, 3)), [eta.copy()]
    for k in range(30_000):
        tau = np.array([[leader_input((k + stage) * 0.01)] for stage in (0.0, 0.5, 1.0)])
        hull.advance(eta, nu, tau, w, STILL[: len(eta)], parameters, 0.01)
        if (k + 1) % 100 == 0:
            poses.append(eta.copy())
    expected = np.stack([reference[name] for name in ("x0_m", "y0_m", "psi0_rad")], axis=-1)
    # the file has nine digits, the positions reach 110 m
    np.testing.assert_allclose(np.array(poses)[:, 0], expected, rtol=0.0, atol=2e-6)


def test_drifting_boat_loses_energy_to_drag_alone() -> None:
    eta, nu, parameters = START.copy(), 3.0 * SPEED, hull.stack([NOMINAL, LIGHT])
    idle, h_s = np.zeros((3, 2, 2)), 0.001
    for _ in range(1000):
        before = nu.copy()
        hull.advance(eta, nu, idle, np.zeros((2, 3)), STILL[: len(eta)], parameters, h_s)
        gained = 0.5 * np.sum(parameters[:, :3] * (nu**2 - before**2), axis=1)
        drag = np.sum(parameters[:, 3:6] * (0.5 * (nu + before)) ** 2, axis=1)
        assert (gained < 0.0).all()
        np.testing.assert_allclose(gained, -drag * h_s, rtol=1e-3)


@pytest.mark.parametrize("moment", [-0.2, 0.0, 0.2])
def test_boat_under_constant_thrust_ends_in_a_steady_turn(moment: float) -> None:
    eta, nu = np.zeros((1, 3)), np.zeros((1, 3))
    tau = np.tile([2.0, moment], (3, 1, 1))
    for _ in range(6000):
        hull.advance(eta, nu, tau, np.zeros((1, 3)), STILL[:1], hull.stack([NOMINAL]), 0.01)
    (u, v, r), p = nu[0], NOMINAL
    assert p.d11 * u - p.m22 * v * r == pytest.approx(2.0)
    assert p.d22 * v + p.m11 * u * r == pytest.approx(0.0, abs=1e-12)
    assert p.d33 * r + (p.m22 - p.m11) * u * v == pytest.approx(moment)
    assert np.sign(r) == np.sign(moment) == np.sign(eta[0, 1])


def test_heading_of_a_circling_boat_is_not_wrapped() -> None:
    eta, nu, tau = np.zeros((1, 3)), np.zeros((1, 3)), np.tile([2.0, 0.5], (3, 1, 1))
    for _ in range(3000):
        hull.advance(eta, nu, tau, np.zeros((1, 3)), STILL[:1], hull.stack([NOMINAL]), 0.01)
    assert eta[0, 2] > 2.0 * np.pi


def test_boat_sails_the_same_bits_alone_and_in_a_fleet() -> None:
    fleet = sail(0.01, 5.0, START, SPEED, DISTURBANCE)
    alone = sail(0.01, 5.0, START[:1], SPEED[:1], DISTURBANCE[:1])
    again = sail(0.01, 5.0, START, SPEED, DISTURBANCE)
    assert fleet.tobytes() == again.tobytes()
    assert fleet[0].tobytes() == alone[0].tobytes()


def test_paper_vessel_on_still_water_sails_the_bits_of_the_general_hull() -> None:
    parameters = hull.stack([NOMINAL, LIGHT])
    # too little a drag to change a bit, enough to be no hull of the paper's
    least = hull.stack([replace(one, d33_quadratic=5e-324) for one in (NOMINAL, LIGHT)])
    quick, general = (START.copy(), SPEED.copy()), (START.copy(), SPEED.copy())
    tau = np.random.default_rng(1).normal(size=(3, 2, 2))
    for _ in range(500):
        hull.advance(*quick, tau, DISTURBANCE, STILL, parameters, 0.01)
        hull.advance(*general, tau, DISTURBANCE, STILL, least, 0.01)
    assert quick[0].tobytes() == general[0].tobytes()
    assert quick[1].tobytes() == general[1].tobytes()
