# SPDX-License-Identifier: MIT
"""Periodic motions between their samples, compared with the sampled functions."""

import numpy as np
import pytest

from sil.certificate.motion import Series, body_from_ground, ground_from_body, motion_of

TIMES = np.array([3.0, 3.21, 7.77, 12.9, -4.0, 103.3])


def test_sampled_sines_and_their_rates_are_interpolated_exactly() -> None:
    window_s, begin_s, samples = 10.0, 3.0, 64
    omega = 2.0 * np.pi / window_s
    at = begin_s + window_s * np.arange(samples) / samples
    values = np.column_stack([1.0 + np.sin(omega * at), np.cos(7 * omega * at)])
    series = Series(begin_s, window_s, values)
    expected = np.column_stack([1.0 + np.sin(omega * TIMES), np.cos(7 * omega * TIMES)])
    rates = np.column_stack([omega * np.cos(omega * TIMES), -7 * omega * np.sin(7 * omega * TIMES)])
    np.testing.assert_allclose(series.at(TIMES), expected, atol=1e-12)
    np.testing.assert_allclose(series.rate(TIMES), rates, atol=1e-11)


def test_boat_on_a_straight_leg_continues_for_ever() -> None:
    eta = np.array([[1.0, 2.0, 0.5], [1.3, 2.4, 0.5]])
    motion = motion_of(0.0, 2.0, eta, np.array([[0.25, 0.0, 0.0]]))
    np.testing.assert_allclose(
        motion.eta(np.array([-2.0, 4.0])), [[0.7, 1.6, 0.5], [1.6, 2.8, 0.5]]
    )
    np.testing.assert_allclose(motion.eta_dot(np.array([9.0])), [[0.15, 0.2, 0.0]])
    np.testing.assert_allclose(motion.nu_dot(np.array([9.0])), 0.0)


def test_boat_on_a_circle_is_where_the_circle_is() -> None:
    psi = 2.0 * np.pi * np.arange(65) / 64
    eta = np.column_stack([2.0 * np.sin(psi), 2.0 - 2.0 * np.cos(psi), psi])
    motion = motion_of(0.0, 10.0, eta, np.tile([0.4 * np.pi, 0.0, 0.2 * np.pi], (64, 1)))
    turn = 0.2 * np.pi * TIMES
    circle = np.column_stack([2.0 * np.sin(turn), 2.0 - 2.0 * np.cos(turn), turn])
    np.testing.assert_allclose(motion.eta(TIMES), circle, atol=1e-10)


@pytest.mark.parametrize("psi", [0.0, 0.7, -2.0])
def test_vectors_turned_into_the_boats_axes_and_back_are_the_same(psi: float) -> None:
    vector = np.array([0.3, -1.2])
    turned = body_from_ground(np.array(psi), vector)
    assert turned[0] == pytest.approx(np.cos(psi) * 0.3 + np.sin(psi) * -1.2)
    np.testing.assert_allclose(ground_from_body(np.array(psi), turned), vector)
