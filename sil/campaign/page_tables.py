# SPDX-License-Identifier: MIT
"""Tables of a campaign's report: headers, and rows of text."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sil.campaign.finished import DIVERGED, FAILED, Campaign
from sil.campaign.samples import Samples
from sil.plant.hull import Array
from sil.report.headline import Ended
from sil.view.history import LENGTH_M

Cells = list[str]
PERCENTS = (5.0, 25.0, 50.0, 75.0, 95.0, 100.0)
ERRORS = (
    "boat",
    "5 %",
    "25 %",
    "median",
    "75 %",
    "95 %",
    "largest",
    "runs settled",
    "settled at (s)",
)
THRUST = ("boat", "RMS (N)", "RMS, 95 % (N)", "step RMS (N)", "step RMS, 95 % (N)")
WORST = ("run", "boat", "95 % of |e| (m)", "RMS (m)")
LOST = ("run", "outcome", "reason")
NEAR = ("run", "closest two boats (m)")
MOST_WORST, MOST_LOST = 5, 20


def errors(campaign: Campaign, samples: Samples) -> list[Cells]:
    """Percentiles of |e| of each boat over late seconds and all runs, and its settling."""
    settling_s = campaign.cells["settling_time_s"]
    settled = ~np.isnan(settling_s) & campaign.ok[:, None]
    rows = []
    for i, percentiles in enumerate(samples.late_percentiles(PERCENTS)):
        times_s = np.where(settled[:, i], settling_s[:, i], np.inf)
        typical_s = _percentile(times_s, 50.0)
        rows.append(
            [
                str(i + 1),
                *(number(value, 4) for value in percentiles),
                f"{settled[:, i].sum()} of {settled.shape[0]}",
                "never" if math.isinf(typical_s) else number(typical_s, 1),
            ]
        )
    return rows


def thrust(campaign: Campaign) -> list[Cells]:
    """Median and 95th percentile over the runs that did not diverge, one row for each boat."""
    ok = campaign.ok
    columns = [campaign.cells[name][ok] for name in ("thrust_rms_N", "thrust_step_rms_N")]
    return [
        [str(i + 1)]
        + [number(_percentile(c[:, i], percent), 3) for c in columns for percent in (50.0, 95.0)]
        for i in range(campaign.boats)
    ]


def states(campaign: Campaign) -> tuple[Cells, list[Cells]]:
    """Header and rows: mean seconds a run in each state that occurs; the number of such runs."""
    seconds = {
        name.removeprefix("s_"): values[campaign.outcome != FAILED]
        for name, values in campaign.cells.items()
        if name.startswith("s_") and np.nansum(values) > 0.0
    }
    rows = [
        [str(i + 1)]
        + [f"{s[:, i].mean():.1f} s in {np.sum(s[:, i] > 0.0)} runs" for s in seconds.values()]
        for i in range(campaign.boats)
    ]
    return ["boat", *seconds], rows


def worst(campaign: Campaign) -> list[tuple[int, Cells]]:
    """Runs that did not diverge, the worst first: by their worst boat's 95 % of |e|."""
    error_m = np.nan_to_num(campaign.cells["error_p95_m"], nan=np.inf)
    ok = np.flatnonzero(campaign.ok)
    order = ok[np.argsort(-error_m[ok].max(axis=1), kind="stable")]
    rows = []
    for index in order[:MOST_WORST]:
        boat = int(error_m[index].argmax())
        run, rms_m = int(campaign.runs[index]), campaign.cells["rms_error_m"][index, boat]
        rows.append(
            (run, [str(run), str(boat + 1), number(error_m[index, boat], 4), number(rms_m, 4)])
        )
    return rows


def lost(campaign: Campaign) -> tuple[list[tuple[int, Cells]], int]:
    """The first runs that diverged or failed, with their reasons; the number of further ones."""
    found = np.flatnonzero(~campaign.ok)
    rows = []
    for index in found[:MOST_LOST]:
        run = int(campaign.runs[index])
        rows.append((run, [str(run), str(campaign.outcome[index]), str(campaign.reason[index])]))
    return rows, max(0, found.size - MOST_LOST)


def near(campaign: Campaign) -> list[tuple[int, Cells]]:
    """Runs in which two boats came nearer than a hull's length, the nearest first."""
    if campaign.boats < 2:
        return []
    least_m = campaign.cells["min_separation_m"][:, 0]
    order = np.argsort(least_m, kind="stable")[: int(np.sum(least_m < _longest_m(campaign)))]
    found = [(int(campaign.runs[index]), least_m[index]) for index in order[:MOST_WORST]]
    return [(run, [str(run), number(apart_m, 2)]) for run, apart_m in found]


def separation(campaign: Campaign) -> str:
    """A sentence on the closest two boats of a run, over the runs that did not diverge."""
    ok = campaign.ok
    least_m, runs = campaign.cells["min_separation_m"][ok, 0], campaign.runs[ok]
    if not np.isfinite(least_m).any():
        return "one boat, or no run that did not diverge"
    low, typical = (number(_percentile(least_m, percent), 2) for percent in (5.0, 50.0))
    closest = int(np.nanargmin(least_m))
    return (
        f"{number(least_m[closest], 2)} m in run {runs[closest]}, the closest; "
        f"{low} m or less in 5 % of the runs; {typical} m or less in half of them"
    )


def ended(campaign: Campaign) -> Ended:
    """Numbers of runs by their end, for the verdict."""
    hull_m = _longest_m(campaign)
    least_m = campaign.cells["min_separation_m"][:, 0]
    return Ended(
        runs=campaign.runs.size,
        settled=int(np.sum(np.isfinite(campaign.worst("settling_time_s")) & campaign.ok)),
        near=int(np.sum(least_m < hull_m)) if campaign.boats > 1 else None,
        diverged=int(np.sum(campaign.outcome == DIVERGED)),
        failed=int(np.sum(campaign.outcome == FAILED)),
        hull_m=hull_m,
    )


def _longest_m(campaign: Campaign) -> float:
    """Length of the longest hull of the campaign's scenario."""
    document: Mapping[str, Any] = campaign.header.get("document", {})
    tables = [document, *document.get("boat", [])]
    return max(table.get("vessel", {}).get("length_m") or LENGTH_M for table in tables)


def number(value: float, digits: int) -> str:
    """A figure in the pages' format."""
    return "∞" if math.isinf(value) else "–" if math.isnan(value) else f"{value:.{digits}f}"


def _percentile(values: Array | Sequence[float], percent: float) -> float:
    if len(values) == 0:
        return math.nan
    return float(np.percentile(values, percent, method="inverted_cdf"))
