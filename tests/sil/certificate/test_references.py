# SPDX-License-Identifier: MIT
"""The reference's figures against an adaptive integrator, the paper's and the equations."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sil.certificate.references import Reference, references
from sil.plant.hull import Array, HullParameters
from sil.scenario import presets, scenario
from tests.sil.certificate.made_up import AT_REST, SINE, reference


@pytest.fixture(scope="module")
def paper() -> Reference:
    return reference()


def test_papers_reference_has_the_figures_that_were_recomputed(paper: Reference) -> None:
    assert paper.kind == "periodic"
    assert paper.T_s == pytest.approx(20.944, abs=5e-4)
    assert paper.omega_max == pytest.approx(0.352, abs=5e-4)
    assert paper.mu == pytest.approx(1.294, abs=5e-4)
    assert paper.omega_bar == paper.omega_max > paper.omega_dot_max


def leader_rates(p: HullParameters, t_s: float, state: Array) -> Array:
    u, v, r, _ = state
    return np.array(
        [
            (2.0 + p.m22 * v * r - p.d11 * u) / p.m11,
            (-p.m11 * u * r - p.d22 * v) / p.m22,
            (0.3 * np.sin(0.3 * t_s) - (p.m22 - p.m11) * u * v - p.d33 * r) / p.m33,
            r * r,
        ]
    )


def test_excitation_is_that_of_an_adaptive_integrator_from_any_time_on(paper: Reference) -> None:
    p = scenario.load("diamond").hulls()[0]
    T = 2.0 * np.pi / 0.3
    solution = solve_ivp(
        lambda t, y: leader_rates(p, t, y),
        (0.0, 12.0 * T),
        np.zeros(4),
        "DOP853",
        dense_output=True,
        rtol=1e-12,
        atol=1e-13,
    )
    assert solution.sol is not None
    begin = 8.0 * T + np.linspace(0.0, T, 200)
    excitation = solution.sol(begin + T)[3] - solution.sol(begin)[3]
    assert paper.mu == pytest.approx(excitation.min(), rel=1e-8)
    late = 10.0 * T + np.linspace(0.0, T, 50)
    np.testing.assert_allclose(paper.motion.nu(late), solution.sol(late)[:3].T, atol=1e-9)
    speeds = np.array([leader_rates(p, t, solution.sol(t)) for t in late])[:, :3]
    np.testing.assert_allclose(paper.motion.nu_dot(late), speeds, atol=1e-8)


def test_straight_leg_excites_nothing() -> None:
    straight = reference(SINE)
    assert (straight.kind, straight.T_s, straight.mu) == ("straight", None, 0.0)
    np.testing.assert_allclose(straight.motion.nu(np.array([5.0])), [[2.0 / 3.436, 0.0, 0.0]])


def test_leader_without_thrust_comes_to_rest() -> None:
    idle = reference(*AT_REST, "leader.nu=[0.5, 0.1, 0.2]")
    assert idle.kind == "rest"
    np.testing.assert_array_equal(idle.motion.nu_periodic.values, [[0.0, 0.0, 0.0]])


def test_constant_moment_ends_in_a_steady_turn_that_excites_as_long_as_it_lasts() -> None:
    turning = reference(SINE, "leader.input.1.yaw_Nm=0.1")
    p = scenario.load("diamond").hulls()[0]
    u, v, r = turning.motion.nu_periodic.values[0]
    assert turning.kind == "turning"
    assert p.d11 * u - p.m22 * v * r == pytest.approx(2.0)
    assert p.d22 * v + p.m11 * u * r == pytest.approx(0.0, abs=1e-9)
    assert turning.motion.window_s == pytest.approx(2.0 * np.pi / r)
    np.testing.assert_allclose(turning.motion.drift, [0.0, 0.0, 2.0 * np.pi], atol=1e-6)
    assert turning.T_s is not None and turning.mu / turning.T_s == pytest.approx(r * r)


def test_window_of_a_leader_that_turns_on_average_brings_its_heading_back() -> None:
    motion = reference("leader.input.1.yaw_Nm=0.07").motion
    turns = motion.drift[2] / (2.0 * np.pi)
    assert motion.window_s > 21.0
    assert abs(turns - round(turns)) < 0.02


def test_each_input_and_the_time_before_the_first_is_a_reference() -> None:
    inputs = "[{from_s = 30.0, surge_N = 2.0, yaw_Nm = 0.1}, {from_s = 90.0}]"
    late = scenario.load("diamond", ["duration_s=200.0", f"leader.input={inputs}"])
    found = references(late)
    assert [r.kind for r in found] == ["rest", "turning", "rest"]
    assert [r.from_s for r in found] == [0.0, 30.0, 90.0]


def test_input_after_the_end_of_the_run_is_no_reference() -> None:
    inputs = "[{surge_N = 2.0}, {from_s = 60.0}]"
    ended = scenario.load("diamond", ["duration_s=50.0", f"leader.input={inputs}"])
    assert [r.kind for r in references(ended)] == ["straight"]


def test_a_route_is_examined_straight_and_in_its_sharpest_turns() -> None:
    found = references(scenario.load("square"))
    assert [one.kind for one in found] == ["rest", "straight", "turning"]
    speed = np.hypot(*found[1].motion.nu_periodic.values[0, :2])
    assert speed == pytest.approx(0.6)
    # Rounded with 15 m at the speed that the outermost slot can keep, 6 m farther out.
    assert found[2].omega_max == pytest.approx(0.6 / (15.0 + 6.0), rel=0.01)


@pytest.mark.parametrize("name", presets.names())
def test_every_hull_sails_its_routes_sharpest_turn(name: str) -> None:
    chosen = scenario.load("square", [f'hull="{name}"'])
    found = references(chosen)
    sailed = chosen.route()[: chosen.ticks]
    assert found[-1].kind == "turning"
    sharpest = np.abs(sailed[:, 5]).max()
    if name == "heron":  # under a constant wrench its turn grows sharper by itself
        assert sharpest < found[-1].omega_max < 0.2
    else:
        assert found[-1].omega_max == pytest.approx(sharpest, rel=1e-6)
    surge = max(one.motion.nu_periodic.values[0, 0] for one in found)
    assert surge == pytest.approx(sailed[:, 3].max(), rel=1e-6)
