# SPDX-License-Identifier: MIT
"""The figures of runs that are compared between two campaigns."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from sil.campaign import change
from sil.campaign.change import Change
from sil.campaign.finished import Campaign
from sil.plant.hull import Array


@dataclass(frozen=True)
class Figure:
    """A quantile over runs of a figure; values below `least` count as `least`.

    `of`: the value of every run (R), infinite if the run has none because it went wrong. `of_ok`:
    only runs that went well in both campaigns count.
    """

    key: str
    what: str
    of: Callable[[Campaign], Array]
    least: float
    share: float = 0.5
    of_ok: bool = False
    less_is_worse: bool = False


LOST = "lost"
LEAST_RUNS = 20
"""With fewer runs, chance cannot be distinguished from change."""


def _worst(name: str) -> Callable[[Campaign], Array]:
    def of(campaign: Campaign) -> Array:
        return np.where(campaign.ok, np.nan_to_num(campaign.worst(name), nan=np.inf), np.inf)

    return of


def _thrust(campaign: Campaign) -> Array:
    return np.asarray(np.sqrt(np.mean(np.square(campaign.cells["thrust_rms_N"]), axis=1)))


def _separation(campaign: Campaign) -> Array:
    return campaign.cells["min_separation_m"][:, 0]


FIGURES = (
    Figure("rms_error_m", "RMS |e|, worst boat (m)", _worst("rms_error_m"), 1e-3),
    Figure("rms_error_p95_m", "… 95th percentile", _worst("rms_error_m"), 1e-3, share=0.95),
    Figure("settling_time_s", "all settled at (s)", _worst("settling_time_s"), 0.1),
    Figure("thrust_rms_N", "RMS thrust (N)", _thrust, 0.01, of_ok=True),
    Figure(
        "thrust_step_rms_N",
        "RMS thrust step, worst boat (N)",
        _worst("thrust_step_rms_N"),
        0.01,
        of_ok=True,
    ),
    Figure(
        "min_separation_m",
        "closest two boats (m)",
        _separation,
        0.01,
        of_ok=True,
        less_is_worse=True,
    ),
)
WHAT = {figure.key: figure.what for figure in FIGURES} | {LOST: "diverged or failed"}
"""Meaning of each figure, by key; medians over runs unless the text says otherwise."""


def compare(a: Campaign, b: Campaign, *, paired: bool) -> dict[str, Change]:
    """The change of every figure, by key; figures of too few runs are left out.

    `paired`: both campaigns have the same runs, in the same order.
    """
    tests = len(WHAT)
    found = {}
    for figure in FIGURES:
        own, other = figure.of(a), figure.of(b)
        if figure.of_ok:
            ok, other_ok = a.ok, b.ok
            if paired:
                ok = other_ok = ok & other_ok
            own, other = own[ok], other[other_ok]
        enough = min(own.size, other.size) >= LEAST_RUNS
        if enough and not (np.isnan(own).any() or np.isnan(other).any()):
            found[figure.key] = change.of_ratio(
                own,
                other,
                figure.share,
                tests,
                least=figure.least,
                paired=paired,
                less_is_worse=figure.less_is_worse,
            )
    found[LOST] = change.of_share(~a.ok, ~b.ok, tests, paired=paired)
    return found
