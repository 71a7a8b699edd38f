# SPDX-License-Identifier: MIT
"""White noise and the sum of forces."""

import numpy as np
import pytest

from sil.plant import hull, propeller
from sil.plant.bodies import Bodies
from sil.plant.hull import Array, HullParameters
from sil.plant.propeller import PropellerParameters
from sil.plant.weather import Weather, WhiteNoise

ETA, NU = np.zeros((1, 3, 3)), np.zeros((1, 3, 3))


def noise(power: float, sample_s: float, h_s: float, steps: int, seed: int = 1) -> Array:
    """Forces (steps, 3 boats, 3 axes)."""
    source = WhiteNoise([power], sample_s, [np.random.default_rng(seed)], 3)
    w = np.zeros((steps, 1, 3, 3))
    for k in range(steps):
        source.push(k * h_s, ETA, NU, h_s, w[k])
    return w[:, 0]


def test_papers_noise_has_variance_10_on_each_axis_and_no_memory() -> None:
    w = noise(0.1, 0.01, 0.01, 20_000)
    np.testing.assert_allclose(w.var(axis=0), 10.0, rtol=0.05)
    np.testing.assert_allclose(w.mean(axis=0), 0.0, atol=0.1)
    columns = w.reshape(20_000, 9)
    assert np.abs(np.corrcoef(columns.T) - np.eye(9)).max() < 0.04
    assert np.abs(np.mean(columns[1:] * columns[:-1], axis=0)).max() < 0.4


def test_noise_is_held_for_its_sample_time() -> None:
    w = noise(0.1, 0.01, 0.0025, 4000)
    held = w.reshape(1000, 4, 9)
    assert (held == held[:, :1]).all()
    assert (np.diff(held[:, 0], axis=0) != 0.0).all()
    np.testing.assert_allclose(held[:, 0].var(axis=0), 10.0, rtol=0.2)


def test_impulse_of_the_noise_does_not_depend_on_its_sample_time() -> None:
    for sample_s in (0.01, 0.05):
        impulse = 0.01 * noise(0.1, sample_s, 0.01, 40_000).reshape(400, 100, 9).sum(axis=1)
        assert impulse.var() == pytest.approx(0.1, rel=0.1)


def test_numbers_of_a_run_are_those_of_its_generator_one_sample_after_the_other() -> None:
    rng = np.random.default_rng(1)
    expected = [np.sqrt(0.1 / 0.02) * rng.standard_normal((3, 3)) for _ in range(150)]
    assert (noise(0.1, 0.02, 0.01, 300)[::2] == expected).all()


def test_every_run_has_its_own_noise_and_a_run_without_draws_nothing() -> None:
    rngs = [np.random.default_rng(1) for _ in range(3)]
    source = WhiteNoise([0.1, 0.0, 0.4], 0.01, rngs, 3)
    w = np.zeros((3, 3, 3))
    source.push(0.0, np.zeros((3, 3, 3)), np.zeros((3, 3, 3)), 0.01, w)
    assert (w[0] != 0.0).all() and (w[1] == 0.0).all()
    np.testing.assert_allclose(w[2], 2.0 * w[0])
    assert rngs[1].random() == np.random.default_rng(1).random()


@pytest.mark.parametrize("sample_s", [0.015, 0.004, 1e-9])
def test_sample_that_is_no_whole_number_of_steps_is_refused(sample_s: float) -> None:
    with pytest.raises(ValueError, match=r"is not a whole number of steps of 0\.01 s"):
        noise(0.1, sample_s, 0.01, 1)


class Steady:
    """A user-defined force that records the times of its evaluations."""

    def __init__(self, force: float) -> None:
        self.force, self.asked = force, list[float]()

    def push(self, t_s: float, _eta: Array, _nu: Array, _h_s: float, w: Array, /) -> None:
        self.asked.append(t_s)
        w += self.force


def test_weather_is_the_sum_of_its_forces_at_the_time_of_each_step() -> None:
    first, second = Steady(1.0), Steady(-3.0)
    weather = Weather([first, second])
    w = np.ones((1, 3, 3))
    for _ in range(3):
        weather.step(ETA, NU, w, 0.5)
        assert (w == -2.0).all()
    assert first.asked == second.asked == [0.0, 0.5, 1.0]


def test_weather_and_current_move_the_boats_and_leave_the_virtual_leader_alone() -> None:
    hulls = hull.stack([HullParameters(1.0, 2.0, 0.4, 3.0, 19.0, 0.9)] * 3)
    propellers = propeller.stack([PropellerParameters(0.25, 50.0, 50.0, 0.0, 0.0)] * 2)
    calm_water, running = np.zeros((3, 2)), np.array([[0.0, 0.0], [0.1, 0.0], [0.1, 0.0]])
    moved = []
    for sea in ((calm_water,), (calm_water, Weather([Steady(1.0)])), (running,)):
        bodies = Bodies(hulls, propellers, np.zeros((3, 3)), np.zeros((3, 3)), *sea)
        bodies.advance(np.zeros((2, 2)), np.ones((3, 1, 2)), 0.01)
        moved.append(bodies.nu)
    calm, pushed, carried = moved
    assert (
        (calm[1:] == 0.0).all() and (calm[0] == pushed[0]).all() and (calm[0] == carried[0]).all()
    )
    assert (pushed[1:] > 0.0).all()
    assert (carried[1:, 0] > 0.0).all() and (carried[1:, 1:] == 0.0).all()
