# SPDX-License-Identifier: MIT
"""What the navigation unit measures."""

import numpy as np

from sil.plant.sensors import SensorNoise, measure

ETA, NU = np.array([[10.0, -4.0, 0.5]]), np.array([[0.6, 0.05, 0.3]])
NOISE = SensorNoise(position_m=0.02, heading_rad=0.01, velocity_mps=0.03, yaw_rate_radps=0.004)


def test_unit_without_noise_measures_the_exact_state_and_draws_nothing() -> None:
    rng = np.random.default_rng(1)
    eta, nu = measure(ETA, NU, SensorNoise().sigma, rng)
    assert (eta == ETA).all() and (nu == NU).all() and eta is not ETA and nu is not NU
    assert rng.random() == np.random.default_rng(1).random()


def test_same_seed_measures_the_same_noise() -> None:
    first, second = (measure(ETA, NU, NOISE.sigma, np.random.default_rng(7)) for _ in range(2))
    assert (first[0] == second[0]).all() and (first[1] == second[1]).all()


def test_noise_of_each_quantity_has_its_own_standard_deviation_and_no_bias() -> None:
    rng, count = np.random.default_rng(3), 40_000
    eta, nu = measure(np.tile(ETA, (count, 1)), np.tile(NU, (count, 1)), NOISE.sigma, rng)
    np.testing.assert_allclose((eta - ETA).std(axis=0), [0.02, 0.02, 0.01], rtol=0.02)
    np.testing.assert_allclose((nu - NU).std(axis=0), [0.03, 0.03, 0.004], rtol=0.02)
    np.testing.assert_allclose(eta.mean(axis=0), ETA[0], atol=5e-4)
    np.testing.assert_allclose(nu.mean(axis=0), NU[0], atol=8e-4)
