# SPDX-License-Identifier: MIT
"""The parts of the search, each against what a textbook or a plain simulation gives."""

from dataclasses import replace

import numpy as np
import pytest
import scipy  # imports signal on first use, which would add half a second to each collection

from sil.identify.equations import Point, Problem, _perturbed, places_of
from sil.identify.hull_terms import GUSTS, INDEX, LOCAL
from sil.identify.identification import problem_of
from sil.identify.output_error import _alike
from sil.identify.voyage_log import SAMPLE_S, Array
from sil.identify.voyage_model import Body, simulate
from sil.identify.windows import first_start
from tests.sil.identify.sailed import levels, sail


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8])
def test_samples_whose_neighbours_correlate_count_as_fewer(rho: float) -> None:
    normals = np.random.default_rng(1).normal(size=(1000, 300))
    error = scipy.signal.lfilter([1.0], [1.0, -rho], normals, axis=0)[500:600]
    assert _alike(error) == pytest.approx((1.0 + rho) / (1.0 - rho), rel=0.1)


def test_a_window_that_is_off_by_the_same_throughout_counts_as_one_sample() -> None:
    off = np.random.default_rng(2).normal(size=300)
    assert _alike(np.tile(off, (100, 1))) == pytest.approx(100.0, rel=0.02)


def sought() -> tuple[Problem, Point, Array]:
    rng = np.random.default_rng(3)
    problem = problem_of([sail(levels(rng, 90.0), rng)], Body(0.28, 1.2, SAMPLE_S))
    count = len(problem.windows)
    values = np.array([term.guess for term in problem.terms])
    z = 0.1 * rng.normal(size=len(values))
    local, gust = rng.normal(size=(1, len(LOCAL))), rng.normal(size=(len(GUSTS), count))
    return problem, Point(z, local, first_start(problem.windows), gust), values


@pytest.mark.parametrize("name", ["m33", "antenna_x", "late_rate", "compass_sin", "wind_n"])
def test_a_changed_term_agrees_with_a_separate_simulation(name: str) -> None:
    problem, point, values = sought()
    out, steps = _perturbed(problem, point, values)
    k = INDEX[name]
    changed = replace(point, z=point.z + steps[k] * (np.arange(len(point.z)) == k))
    guess = np.array([[term.guess, term.spread] for term in problem.terms]).T
    terms = (guess[0] + changed.z * guess[1])[:, None]
    places, start = places_of(problem, changed)[:, :, None], point.start[:, :, None]
    plain = simulate(terms, places, start, problem.windows.commands, problem.body)[..., 0]
    assert np.abs(plain - out[..., 0]).max() > 1e-6
    assert out[..., 1 + k] == pytest.approx(plain, abs=1e-9)


@pytest.mark.parametrize("number", range(len(LOCAL)))
def test_changed_current_and_wind_agree_with_a_separate_simulation(number: int) -> None:
    problem, point, values = sought()
    out, steps = _perturbed(problem, point, values)
    k = len(point.z) + number
    changed = replace(point, local=point.local + steps[k] * (np.arange(len(LOCAL)) == number))
    guess = np.array([[term.guess, term.spread] for term in problem.terms]).T
    terms = (guess[0] + point.z * guess[1])[:, None]
    places, start = places_of(problem, changed)[:, :, None], point.start[:, :, None]
    plain = simulate(terms, places, start, problem.windows.commands, problem.body)[..., 0]
    assert out[..., 1 + k] == pytest.approx(plain, abs=1e-9)
