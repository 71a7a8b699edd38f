# SPDX-License-Identifier: MIT
"""Predictions begin where the boat was."""

from dataclasses import replace

import numpy as np

from sil.identify.identification import problem_of
from sil.identify.score import score
from sil.identify.voyage_log import SAMPLE_S
from sil.identify.voyage_model import Body
from tests.sil.identify.sailed import levels, sail


def test_a_window_that_begins_in_a_gap_is_not_scored() -> None:
    rng = np.random.default_rng(6)
    log = sail(levels(rng, 90.0), rng)
    log.motion[:, :2] += [300.0, 400.0]  # at north 0, east 0 it would be 500 m off
    broken = replace(log, motion=log.motion.copy())
    broken.motion[395:405] = np.nan
    problem = problem_of([log], Body(0.28, 1.2, SAMPLE_S))
    values = np.array([term.guess for term in problem.terms])
    found = [score(problem, values, np.zeros((1, 4)), [of]) for of in (log, broken)]
    whole, part = (one for one in found if one is not None)
    assert part.windows == whole.windows - 1  # the one that begins at 40 s
    assert part.ninetieth_m < 2.0 * whole.ninetieth_m
