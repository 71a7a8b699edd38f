# SPDX-License-Identifier: MIT
"""The navigation units' measurements."""

from dataclasses import replace

import numpy as np

from sil.plant import hull, propeller
from sil.plant.bodies import Bodies
from sil.plant.hull import Array, HullParameters
from sil.plant.propeller import PropellerParameters
from sil.plant.sensors import SensorNoise, Sensors

ETA, NU = np.array([10.0, -4.0, 0.5]), np.array([0.6, 0.05, 0.3])
NOISE = SensorNoise(position_m=0.02, heading_rad=0.01, velocity_mps=0.03, yaw_rate_radps=0.004)
EXACT = SensorNoise()
H_S = 0.01


def adrift(runs: int, boats: int) -> Bodies:
    agents = runs * (boats + 1)
    hulls = hull.stack([HullParameters(1.0, 1.0, 1.0, 1.0, 1.0, 1.0)] * agents)
    propellers = propeller.stack([PropellerParameters(0.1, 1.0, 1.0, 0.0, 0.0)] * runs * boats)
    eta, nu = np.tile(ETA, (agents, 1)), np.tile(NU, (agents, 1))
    return Bodies(hulls, propellers, eta, nu, np.zeros((agents, 2)))


def measured(noise: list[SensorNoise], boats: int, times: int) -> tuple[Array, Array, Array]:
    """Poses of leaders (times, R, 3), poses and velocities of boats (times, R, boats, 3).

    The generators are 3, 4, …
    """
    runs = len(noise)
    rngs = [[np.random.default_rng(3 + n * runs + run) for run in range(runs)] for n in range(2)]
    sensors, taken = Sensors(noise, rngs, adrift(runs, boats), H_S), []
    for _ in range(times):
        sensors.measure()
        taken.append([sensors.eta.copy(), sensors.nu.copy()])
    eta, nu = np.moveaxis(np.array(taken), 1, 0)
    shape = (times, runs, boats, 3)
    return eta[:, :runs], eta[:, runs:].reshape(shape), nu[:, runs:].reshape(shape)


def test_unit_without_noise_measures_the_exact_state_and_draws_nothing() -> None:
    rngs, drifts = ([np.random.default_rng(seed) for seed in pair] for pair in ((1, 2), (3, 4)))
    for noise in ([EXACT, EXACT], [EXACT, NOISE]):
        sensors = Sensors(noise, [rngs, drifts], adrift(2, 1), H_S)
        sensors.measure()
        assert (sensors.eta[2] == ETA).all() and (sensors.nu[2] == NU).all()
    assert rngs[0].random() == np.random.default_rng(1).random()
    assert rngs[1].random() != np.random.default_rng(2).random()
    assert [rng.random() for rng in drifts] == [np.random.default_rng(n).random() for n in (3, 4)]


def test_virtual_leader_knows_its_state() -> None:
    leaders, eta, nu = measured([NOISE, NOISE], boats=3, times=4)
    assert (leaders == ETA).all()
    assert (eta != ETA).all() and (nu != NU).all()


def test_numbers_of_a_run_are_those_of_its_generator_one_measurement_after_the_other() -> None:
    boats, times = 2, 200
    _, eta, nu = measured([NOISE, EXACT, NOISE], boats, times)
    for run in (0, 2):
        rng = np.random.default_rng(3 + run)
        for k in range(times):
            pose, velocity = rng.standard_normal((2, boats + 1, 3))[:, 1:]
            assert (eta[k, run] == ETA + NOISE.sigma[0] * pose).all()
            assert (nu[k, run] == NU + NOISE.sigma[1] * velocity).all()


def test_noise_of_each_quantity_has_its_own_standard_deviation_and_no_bias() -> None:
    eta, nu = (boats.reshape(-1, 3) for boats in measured([NOISE], 400, 100)[1:])
    np.testing.assert_allclose((eta - ETA).std(axis=0), [0.02, 0.02, 0.01], rtol=0.02)
    np.testing.assert_allclose((nu - NU).std(axis=0), [0.03, 0.03, 0.004], rtol=0.02)
    np.testing.assert_allclose(eta.mean(axis=0), ETA, atol=5e-4)
    np.testing.assert_allclose(nu.mean(axis=0), NU, atol=8e-4)


def test_drift_of_the_position_keeps_its_deviation_and_fades_with_its_time_constant() -> None:
    drifting = SensorNoise(drift_m=0.5, drift_s=0.2)
    _, eta, nu = measured([EXACT, drifting], boats=200, times=400)
    assert (eta[:, 0] == ETA).all() and (nu == NU).all() and (eta[..., 2] == ETA[2]).all()
    off = eta[:, 1, :, :2] - ETA[:2]
    assert abs(off.std(axis=(1, 2)) / 0.5 - 1.0).max() < 0.15  # from the first step on
    kept = (off[20:] * off[:-20]).mean() / (off**2).mean()
    assert abs(kept - np.exp(-1.0)) < 0.03


def test_drift_changes_no_other_number() -> None:
    _, quiet, nu = measured([NOISE], boats=2, times=70)
    _, eta, nu_too = measured([replace(NOISE, drift_m=0.5)], boats=2, times=70)
    assert (nu == nu_too).all() and (eta[..., 2] == quiet[..., 2]).all()
    assert (eta[..., :2] != quiet[..., :2]).all()
