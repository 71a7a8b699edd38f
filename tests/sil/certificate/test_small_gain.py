# SPDX-License-Identifier: MIT
"""The printed formulas: compared with hand calculation, at their limits, and out of range."""

import math

import numpy as np
import pytest

from sil.certificate.motion import motion_of
from sil.certificate.references import Reference
from sil.certificate.small_gain import SmallGain, small_gain
from sil.scenario.sections import Input
from tests.sil.certificate.made_up import SINE, VESSEL, reference


def made_up(T: float, mu: float, omega: float, omega_dot: float = 0.0) -> Reference:
    still = motion_of(0.0, 1.0, np.zeros((2, 3)), np.zeros((1, 3)))
    return Reference(Input(), "periodic", still, T, mu, omega, omega_dot)


@pytest.fixture(scope="module")
def paper() -> SmallGain:
    return small_gain(VESSEL, reference(), 0.2, 0.2)


def test_papers_gains_do_not_pass_the_papers_test(paper: SmallGain) -> None:
    assert paper.bound_holds
    values = (paper.product, paper.above_square_of_sum, paper.above_sum_of_squares)
    assert all(1.6 < value < 1.9 for value in values)
    assert paper.product < paper.above_square_of_sum


def test_formulas_agree_with_a_calculation_by_hand() -> None:
    test = small_gain(VESSEL, made_up(2.0, 0.5, 0.4), 0.2, 0.3)
    # α = (2·0.16/0.2)(1 + (2/(4·0.5))·1.44) = 1.6·2.44; β = 1 + 2·0.16·2 + α + 0.4
    assert test.alpha == pytest.approx(3.904)
    assert test.beta == pytest.approx(5.944)
    assert test.gamma1 == pytest.approx(8.0 * 5.944)
    assert test.gamma2 == pytest.approx(1.012 * 0.2 * 0.4 / 18.99)
    assert test.product == pytest.approx(test.gamma1 * test.gamma2)
    front = 2.0 * 2.0 * 1.012 / (0.5 * 18.99) * 0.2 * 0.4
    assert test.above_square_of_sum == pytest.approx(front * (1.0 + 0.64 + 0.8 + 1.6 * 2.44))
    assert test.above_sum_of_squares == pytest.approx(front * (1.0 + 0.64 + 0.8 + 1.6 * 2.04))
    assert test.k_du_least == pytest.approx(1.012**2 * 0.7**2 / (2.0 * 18.99))
    assert test.bound == pytest.approx((18.99 / 1.012 * 0.25 / (4.0 + 4.0)) ** (1.0 / 3.0))


def test_each_formula_is_one_at_its_largest_gain(paper: SmallGain) -> None:
    for name, value in (
        ("product", paper.k_x_product),
        ("above_square_of_sum", paper.k_x_square_of_sum),
        ("above_sum_of_squares", paper.k_x_sum_of_squares),
    ):
        assert value is not None
        there = small_gain(VESSEL, reference(), value, 0.2)
        assert getattr(there, name) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(("share", "some"), [(0.999, True), (1.001, False)])
def test_some_gain_passes_just_where_the_bound_holds(share: float, some: bool) -> None:
    T, mu = 20.0, 1.3
    bound = small_gain(VESSEL, made_up(T, mu, 0.3), 0.2, 0.2).bound
    test = small_gain(VESSEL, made_up(T, mu, share * bound), 0.2, 0.2)
    assert test.bound_holds is some
    assert (test.k_x_square_of_sum is not None) is some
    assert (test.k_x_sum_of_squares is not None) is some


def test_yaw_acceleration_counts_where_it_is_larger() -> None:
    calm, jerky = (made_up(2.0, 0.5, 0.4, x) for x in (0.1, 0.9))
    assert small_gain(VESSEL, calm, 0.2, 0.2).bound_holds
    assert not small_gain(VESSEL, jerky, 0.2, 0.2).bound_holds


def test_without_excitation_the_formulas_are_infinite_and_certify_nothing() -> None:
    test = small_gain(VESSEL, reference(SINE), 0.2, 0.2)
    assert not test.bound_holds
    assert math.isinf(test.product) and math.isinf(test.above_sum_of_squares)
    assert test.k_x_product is None and test.k_x_sum_of_squares is None
