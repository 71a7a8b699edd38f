# SPDX-License-Identifier: MIT
"""From logs to a hull: wiring, output error, intervals, and prediction of logs not used."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sil.identify import kinematics, oddities, propeller_signs
from sil.identify.equations import Problem
from sil.identify.hull_terms import LOCAL, TERMS
from sil.identify.intervals import Intervals, intervals
from sil.identify.output_error import (
    AT_ONCE,
    BY_AND_BY,
    Fit,
    Schedule,
    Told,
    fit,
    part_of,
)
from sil.identify.score import Score, score
from sil.identify.voyage_log import SAMPLE_S, BadLogError, VoyageLog
from sil.identify.voyage_model import Body
from sil.identify.windows import WINDOW_S, cut

_LEAST_WINDOWS = 6
_HALVES = 0.7  # share of the work in fits to one half
# Difference of the sums of R²: a smaller one does not tell which hull is nearer the truth.
# With BY_AND_BY the log counts for more, and the first guesses for less.
_CLEARLY = 0.1


Halves = tuple[tuple[VoyageLog, ...], tuple[VoyageLog, ...]]
Scores = tuple[Score | None, Score | None]


@dataclass(frozen=True)
class Identification:
    """A hull, its uncertainty, and the oddities of its logs.

    held_out: scores of fits to one half of the logs on the other half, both ways round.
    """

    logs: tuple[VoyageLog, ...]
    wiring: propeller_signs.Wiring
    odd: tuple[str, ...]
    problem: Problem
    fit: Fit
    intervals: Intervals
    held_out: Scores


def identify(logs: Sequence[VoyageLog], body: Body, told: Told) -> Identification:
    """The hull of these logs of one boat. Raises `BadLogError`."""
    for log in logs:
        kinematics.check(log)
    found = propeller_signs.find(logs)
    logs = tuple(propeller_signs.mended(log, found) for log in logs)
    odd = tuple(oddities.of_logs(logs))
    halves = split(logs)
    schedules = (BY_AND_BY, AT_ONCE)
    tried = []
    for k, schedule in enumerate(schedules):
        part = part_of(told, _HALVES * k / len(schedules), _HALVES * (k + 1) / len(schedules))
        tried.append(held_out(halves, body, schedule, part, one_log=len(logs) == 1))
    by_and_by, at_once = map(_worth, tried)
    best = int(by_and_by + _CLEARLY < at_once)
    problem = problem_of(logs, body)
    whole = searched(problem, schedules[best], part_of(told, _HALVES, 1.0))
    return Identification(logs, found, odd, problem, whole, intervals(problem, whole), tried[best])


def held_out(halves: Halves, body: Body, schedule: Schedule, told: Told, one_log: bool) -> Scores:
    """Fit to one half and score on the other, both ways round.

    one_log: the halves are minutes of one log, which share its current and wind; in other logs
    these are unknown.
    """
    scores = []
    for k, (mine, other) in enumerate((halves, halves[::-1])):
        problem = problem_of(mine, body)
        found = searched(problem, schedule, part_of(told, 0.5 * k, 0.5 * (k + 1)))
        place = found.local.mean(axis=0) if one_log else np.zeros(len(LOCAL))
        scores.append(score(problem, found.values, np.tile(place, (len(other), 1)), other))
    return scores[0], scores[1]


def _worth(scores: Scores) -> float:
    """Sum of R² of u and r, each at least -1, so that one bad channel does not decide alone.

    That of v counts only below 0, where the prediction is worse than none: above, gusts and noise
    decide how good it is.
    """
    return sum(max(r2, -1.0) for one in scores if one for r2 in (one.u, one.r, min(one.v, 0.0)))


def problem_of(logs: Sequence[VoyageLog], body: Body) -> Problem:
    """All terms, with windows that do not overlap. Raises `BadLogError` if there are too few."""
    windows = cut(logs)
    if len(windows) < _LEAST_WINDOWS:
        raise BadLogError(
            f"{', '.join(log.name for log in logs)}: the boat moves in only {len(windows)} "
            f"stretches of {WINDOW_S:.0f} s; at least {_LEAST_WINDOWS} are needed. Sail longer."
        )
    terms = tuple(term.of_length(body.length_m) for term in TERMS)
    return Problem(windows, body, terms, np.ones(len(terms), dtype=bool))


def searched(problem: Problem, schedule: Schedule, told: Told) -> Fit:
    """The fit, from the terms' first guesses."""
    return fit(problem, np.array([term.guess for term in problem.terms]), schedule, told)


def split(logs: Sequence[VoyageLog]) -> Halves:
    """Two halves: the first and the last of several logs, or alternate minutes of a single log."""
    if len(logs) > 1:
        middle = len(logs) // 2
        return tuple(logs[:middle]), tuple(logs[middle:])
    parts = _minutes(logs[0])
    return tuple(parts[0::2]), tuple(parts[1::2])


def _minutes(log: VoyageLog) -> list[VoyageLog]:
    step = round(60.0 / SAMPLE_S)
    return [
        replace(log, motion=log.motion[b : b + step], commands=log.commands[b : b + step])
        for b in range(0, len(log.motion), step)
    ]
