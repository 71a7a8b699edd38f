# SPDX-License-Identifier: MIT
"""Waves against their spectrum, forces against integration over the hull, drift against Maruo."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from sil.plant.hull import Array
from sil.plant.waves import Sea, WaveBody, Waves, jonswap

OTTER = WaveBody(85.0, 162.0, 2.0, 0.2, 0.4, 0.0, 0.0)
HEIGHT_M, PERIOD_S, COURSE_RAD = 0.1, 2.0, 0.8


def energy_at(omega: float, peakedness: float) -> float:
    return float(jonswap(np.array(omega), HEIGHT_M, PERIOD_S, peakedness))


def sea(components: int = 40, seed: int = 1) -> Sea:
    return Sea(
        height_m=HEIGHT_M,
        period_s=PERIOD_S,
        course_rad=COURSE_RAD,
        peakedness=3.3,
        components=components,
        rng=np.random.default_rng(seed),
    )


def force(waves: Waves, t_s: float, eta: Array) -> Array:
    """Forces on boats at eta; both (R, N, 3)."""
    w = np.zeros(eta.shape)
    waves.push(t_s, eta, np.zeros(eta.shape), 0.01, w)
    return w


def forces(
    water: Sea, eta: tuple[float, float, float], times: Array, body: WaveBody = OTTER
) -> Array:
    """Forces (T, 3) on a boat that is held at eta."""
    waves = Waves([water], [[body]])
    return np.array([force(waves, t, np.array([[eta]]))[0, 0] for t in times])


def test_surface_has_the_significant_height() -> None:
    times = np.arange(0.0, 4000.0, 0.25)
    for seed in range(3):
        waves = sea(seed=seed)
        series = np.array([waves.elevation_m(t, 4.0, -7.0) for t in times])
        assert series.var() == pytest.approx(HEIGHT_M**2 / 16.0, rel=0.03)
        assert series.mean() == pytest.approx(0.0, abs=0.001)
    # not every wave like the others, and no repetition
    assert np.abs(series).max() > 2.5 * series.std()


def test_energy_lies_where_jonswaps_does() -> None:
    waves = sea(components=400)
    omega, _, amplitude, _ = waves.waves.T
    total = quad(lambda w: energy_at(w, 3.3), 1.0, 15.0, points=[np.pi], limit=200)[0]
    for low, high in ((1.6, 2.8), (2.8, 3.5), (3.5, 5.0), (5.0, 12.0)):
        inside = (omega >= low) & (omega < high)
        share = np.sum(amplitude[inside] ** 2) / np.sum(amplitude**2)
        expected = quad(lambda w: energy_at(w, 3.3), low, high, limit=200)[0] / total
        assert share == pytest.approx(expected, abs=0.02)


def test_pierson_moskowitz_is_jonswap_without_its_peak() -> None:
    energy = quad(lambda w: energy_at(w, 1.0), 0.5, 60.0, points=[np.pi], limit=200)[0]
    assert energy == pytest.approx(HEIGHT_M**2 / 16.0, rel=1e-4)
    omega = np.linspace(0.5, 12.0, 20_000)
    spectrum = jonswap(omega, HEIGHT_M, PERIOD_S, 1.0)
    assert omega[np.argmax(spectrum)] == pytest.approx(2.0 * np.pi / PERIOD_S, rel=1e-3)
    peak = jonswap(np.array(np.pi), HEIGHT_M, PERIOD_S, 3.3)
    assert peak / jonswap(np.array(np.pi), HEIGHT_M, PERIOD_S, 1.0) == pytest.approx(3.3)


def test_waves_travel_on_their_course_at_the_speed_of_deep_water() -> None:
    waves = sea(components=1)
    (omega, k, _, _), (ahead_n, ahead_e) = waves.waves[0], (np.cos(0.8), np.sin(0.8))
    speed = 9.81 / omega
    assert k * speed == pytest.approx(omega)
    for t in (0.0, 0.7, 5.0):
        moved = waves.elevation_m(t, 1.0 + speed * t * ahead_n, 2.0 + speed * t * ahead_e)
        assert moved == pytest.approx(waves.elevation_m(0.0, 1.0, 2.0))
        along_the_crest = waves.elevation_m(t, 1.0 - 9.0 * ahead_e, 2.0 + 9.0 * ahead_n)
        assert along_the_crest == pytest.approx(waves.elevation_m(t, 1.0, 2.0))


def integrated(waves: Sea, eta: tuple[float, float, float], t_s: float, body: WaveBody) -> Array:
    """[X Y N]: inertia per metre of each hull times the water's acceleration there, summed up.

    The acceleration by differences of the orbital velocity ω a e^{kz} cos φ.
    """
    omega, k, amplitude, phase = waves.waves.T
    course = np.array([np.cos(COURSE_RAD), np.sin(COURSE_RAD)])
    cos, sin = np.cos(eta[2]), np.sin(eta[2])
    x = (np.arange(2000) + 0.5) / 2000.0 * body.length_m - 0.5 * body.length_m
    total = np.zeros(3)
    for y in (-body.hull_y_m, body.hull_y_m):
        place = np.stack([eta[0] + cos * x - sin * y, eta[1] + sin * x + cos * y], axis=-1)
        way = (place @ course)[:, None]

        def velocity(t: float, way: Array = way) -> Array:
            decay = np.exp(-k * 0.5 * body.draft_m)
            return np.sum(omega * amplitude * decay * np.cos(omega * t - k * way + phase), axis=1)

        accel = (velocity(t_s + 1e-5) - velocity(t_s - 1e-5)) / 2e-5
        north, east = accel[:, None].T * course[:, None]
        surge = 0.5 * body.m11 * (cos * north + sin * east)
        sway = 0.5 * body.m22 * (cos * east - sin * north)
        total += [surge.mean(), sway.mean(), np.mean(x * sway - y * surge)]
    return total


@pytest.mark.parametrize("psi", [0.8, 0.8 + np.pi / 2, -1.7, 2.9])
def test_first_order_force_is_the_waters_acceleration_over_both_hulls(psi: float) -> None:
    waves, eta = sea(), (12.0, -5.0, psi)
    for t_s in (0.0, 1.3, 77.7):
        expected = integrated(waves, eta, t_s, OTTER)
        given = forces(waves, eta, np.array([t_s]))[0]
        np.testing.assert_allclose(given, expected, rtol=1e-4, atol=1e-4)


def test_boat_longer_than_the_waves_feels_less_of_them_along_its_length() -> None:
    times = np.arange(0.0, 60.0, 0.1)
    dinghy, ship = replace(OTTER, length_m=0.1), replace(OTTER, length_m=20.0)
    short = forces(sea(), (0.0, 0.0, COURSE_RAD), times, dinghy).std(axis=0)
    long = forces(sea(), (0.0, 0.0, COURSE_RAD), times, ship).std(axis=0)
    assert long[0] < 0.2 * short[0]
    across = forces(sea(), (0.0, 0.0, COURSE_RAD + np.pi / 2), times, ship)
    assert across[:, 1].std() > 0.5 * short[0]


def test_drift_of_regular_waves_is_maruos_and_steady() -> None:
    body = replace(OTTER, m11=1e-9, m22=1e-9, drift_x_m=0.05, drift_y_m=0.2)
    waves = sea(components=1)
    amplitude = waves.waves[0, 2]
    times = np.arange(0.0, 20.0, 0.1)
    ahead = forces(waves, (3.0, 4.0, COURSE_RAD), times, body)
    np.testing.assert_allclose(ahead[:, 0], 0.5 * 1025.0 * 9.81 * 0.05 * amplitude**2, rtol=1e-6)
    abeam = forces(waves, (3.0, 4.0, COURSE_RAD - np.pi / 2), times, body)
    np.testing.assert_allclose(abeam[:, 1], 0.5 * 1025.0 * 9.81 * 0.2 * amplitude**2, rtol=1e-6)


def test_drift_of_a_sea_is_slow_varies_and_pushes_with_the_waves() -> None:
    body = replace(OTTER, m11=1e-9, m22=1e-9, drift_x_m=0.05)
    times = np.arange(0.0, 3000.0, 0.1)
    surge = forces(sea(), (0.0, 0.0, COURSE_RAD), times, body)[:, 0]
    assert (surge >= -1e-9).all()
    expected = 0.5 * 1025.0 * 9.81 * 0.05 * HEIGHT_M**2 / 8.0
    assert surge.mean() == pytest.approx(expected, rel=0.1)
    assert surge.std() > 0.5 * expected
    density = np.abs(np.fft.rfft(surge - surge.mean())) ** 2
    frequency = np.fft.rfftfreq(times.size, 0.1)
    # The waves' 0.5 Hz and more do not appear, nor their sums.
    assert density[frequency < 0.5].sum() > 0.9 * density.sum()
    assert density[frequency > 0.9].sum() < 0.02 * density.sum()


def test_same_seed_makes_the_same_sea_and_another_seed_another() -> None:
    eta, times = (1.0, 2.0, 0.3), np.arange(0.0, 5.0, 0.1)
    once = forces(sea(), eta, times)
    assert (once == forces(sea(), eta, times)).all()
    assert np.abs(once - forces(sea(seed=2), eta, times)).max() > 1.0


def test_boats_at_different_places_feel_different_waves() -> None:
    eta = np.array([[[0.0, 0.0, 0.0], [3.0, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    w = force(Waves([sea()], [[OTTER] * 3]), 1.0, eta)[0]
    assert (w[0] == w[2]).all() and np.abs(w[0] - w[1]).max() > 1.0


def test_every_run_has_its_own_sea_as_if_it_were_alone() -> None:
    seas = [sea(components=7), None, sea(seed=2), sea()]
    eta = np.random.default_rng(1).normal(size=(4, 2, 3))
    w = force(Waves(seas, [[OTTER] * 2] * 4), 1.0, eta)
    assert (w[1] == 0.0).all()
    for run in (0, 2, 3):
        alone = force(Waves([seas[run]], [[OTTER] * 2]), 1.0, eta[run : run + 1])
        assert w[run].tobytes() == alone[0].tobytes()
