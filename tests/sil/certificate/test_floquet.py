# SPDX-License-Identifier: MIT
"""Multipliers of eq:26 where they are known: constant turns, straight legs, Liouville's formula."""

import numpy as np
import pytest

from sil.certificate import floquet
from sil.plant.hull import HullParameters
from tests.sil.certificate.made_up import SINE, TURN, VESSEL, reference


@pytest.mark.parametrize("k_x", [0.05, 0.2, 0.9])
def test_multipliers_in_a_constant_turn_are_those_of_a_constant_matrix(k_x: float) -> None:
    turning = reference(*TURN)
    w = turning.omega_max
    a, b = VESSEL.d22 / VESSEL.m22, VESSEL.m11 / VESSEL.m22
    matrix = np.array([[-k_x, w, 0.0], [-w, 0.0, 1.0], [b * k_x * w, 0.0, -a]])
    expected = np.exp(np.linalg.eigvals(matrix))
    (found,) = floquet.multipliers(VESSEL, turning, [k_x])
    np.testing.assert_allclose(
        np.sort_complex(found), np.sort_complex(expected), rtol=1e-7, atol=1e-11
    )
    (decay,) = floquet.decay_rates(turning, found[None])
    assert decay == pytest.approx(-np.linalg.eigvals(matrix).real.max(), rel=1e-7)


def test_product_of_the_multipliers_is_that_of_liouville() -> None:
    fast = HullParameters(1.012, 1.982, 0.354, 3.436, 0.3, 0.864)
    paper = reference()
    values = floquet.multipliers(fast, paper, [0.1, 0.3])
    assert paper.T_s is not None
    trace = -np.array([0.1, 0.3]) - 0.3 / 1.982
    np.testing.assert_allclose(values.prod(axis=1), np.exp(trace * paper.T_s), rtol=1e-6)


def test_papers_gains_are_stable_behind_the_papers_reference() -> None:
    paper = reference()
    values = floquet.multipliers(VESSEL, paper, [0.2])
    (decay,) = floquet.decay_rates(paper, values)
    assert np.abs(values).max() == pytest.approx(0.157, abs=0.001)
    assert decay == pytest.approx(0.088, abs=0.001)


def test_on_a_straight_leg_the_error_abeam_stays() -> None:
    straight = reference(SINE)
    values = floquet.multipliers(VESSEL, straight, [0.2])
    assert values[0, 0] == pytest.approx(1.0, abs=1e-9)
    assert floquet.decay_rates(straight, values)[0] == pytest.approx(0.0, abs=1e-9)
