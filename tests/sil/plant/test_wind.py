# SPDX-License-Identifier: MIT
"""Gusts against their statistics, the wind's force against its formula and plausibility."""

import numpy as np
import pytest
import scipy  # imports signal on first use, which would add half a second to each collection

from sil.plant.hull import Array
from sil.plant.wind import Gusts, Wind, Windage

OTTER = Windage(frontal_m2=0.3, lateral_m2=0.6, c_x=0.7, c_y=0.8, c_n=0.1, length_m=2.0)
H_S = 0.05


def blow(air: tuple[float, float], psi: float, nu: tuple[float, float, float] = (0, 0, 0)) -> Array:
    """Force [X Y N] of a wind without gusts."""
    wind = Wind([air], gusts(0.0, 10.0, 1), [[OTTER]])
    eta, w = np.array([[[5.0, 6.0, psi]]]), np.zeros((1, 1, 3))
    wind.push(0.0, eta, np.array([[nu]], dtype=float), 0.01, w)
    return w[0, 0]


def gusts(sigma_mps: float, time_s: float, *seeds: int) -> Gusts:
    """Gusts of as many runs as there are seeds."""
    rngs = [np.random.default_rng(seed) for seed in seeds]
    return Gusts([sigma_mps] * len(seeds), [time_s] * len(seeds), rngs)


def test_gusts_have_the_spectrum_of_a_first_order_process() -> None:
    sigma, time_s = 0.6, 4.0
    air = gusts(sigma, time_s, 2)
    series = np.array([air.step(H_S)[0] for _ in range(200_000)])
    np.testing.assert_allclose(series.std(axis=0), sigma, rtol=0.05)
    assert abs(np.corrcoef(series.T)[0, 1]) < 0.05
    frequency, density = scipy.signal.welch(series, 1.0 / H_S, nperseg=8192, axis=0)
    expected = 4.0 * sigma**2 * time_s / (1.0 + (2.0 * np.pi * frequency * time_s) ** 2)
    for low, high in ((0.005, 0.02), (0.02, 0.1), (0.1, 0.5), (0.5, 2.0)):
        band = (frequency >= low) & (frequency < high)
        assert density[band].mean() == pytest.approx(expected[band].mean(), rel=0.12)


def test_gusts_do_not_begin_from_a_calm_and_do_not_depend_on_the_step() -> None:
    first = gusts(0.6, 4.0, *range(2000)).step(H_S)
    np.testing.assert_allclose(np.std(first, axis=0), 0.6, rtol=0.05)
    for h_s in (0.01, 0.5):
        air = gusts(0.6, 4.0, 3)
        series = np.array([air.step(h_s)[0] for _ in range(60_000)])
        lag = round(4.0 / h_s)
        correlation = np.mean(series[lag:] * series[:-lag]) / np.mean(series**2)
        assert correlation == pytest.approx(np.exp(-1.0), abs=0.06)


def test_force_is_fossens_with_the_angle_of_attack_written_out() -> None:
    psi, u, v, r = 0.4, 0.9, -0.2, 0.3
    air = np.array([-2.0, 1.5])
    speed, towards = np.hypot(*air), np.arctan2(air[1], air[0])
    u_rw = u - speed * np.cos(towards - psi)
    v_rw = v - speed * np.sin(towards - psi)
    gamma = -np.arctan2(v_rw, u_rw)
    pressure = 0.5 * 1.225 * (u_rw**2 + v_rw**2)
    expected = pressure * np.array(
        [
            -0.7 * np.cos(gamma) * 0.3,
            0.8 * np.sin(gamma) * 0.6,
            0.1 * np.sin(2.0 * gamma) * 0.6 * 2.0,
        ]
    )
    np.testing.assert_allclose(blow((-2.0, 1.5), psi, (u, v, r)), expected, rtol=1e-12)


def test_wind_pushes_where_it_goes_and_turns_the_bow_across_it() -> None:
    from_astern, from_port = blow((3.0, 0.0), 0.0), blow((0.0, 3.0), 0.0)
    assert from_astern[0] > 0.0 and from_astern[1:] == pytest.approx([0.0, 0.0])
    assert from_port[1] > 0.0 and from_port[[0, 2]] == pytest.approx([0.0, 0.0])
    from_starboard_bow = blow((-2.0, -2.0), 0.0)
    assert (from_starboard_bow < 0.0).all(), "astern, to port, and the bow falls off to port"


def test_boat_that_moves_with_the_air_feels_none() -> None:
    assert blow((2.0, 0.0), 0.0, (2.0, 0.0, 0.4)) == pytest.approx([0.0, 0.0, 0.0])


def test_all_boats_of_a_run_are_in_the_same_air_and_the_same_seed_blows_again() -> None:
    wind = Wind([(1.0, 2.0)] * 3, gusts(0.5, 10.0, 9, 8, 9), [[OTTER, OTTER]] * 3)
    eta, nu = np.zeros((3, 2, 3)), np.zeros((3, 2, 3))
    w = np.zeros((100, 3, 2, 3))
    for k in range(100):
        wind.push(0.0, eta, nu, 0.01, w[k])
    assert (w[:, 0] == w[:, 2]).all() and (w[:, 0] != w[:, 1])[..., :2].all()
    assert (w[:, :, 0] == w[:, :, 1]).all()
    assert np.ptp(w[:, 0, 0, 1]) > 0.0
