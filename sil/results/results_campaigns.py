# SPDX-License-Identifier: MIT
"""The paper's Monte Carlo with both laws, for the page of results."""

import argparse
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np

from sil.campaign import campaign, campaign_report, finished, nominal, samples
from sil.campaign.finished import Campaign
from sil.common import pool
from sil.report.comparison import png
from sil.results.claims import BASELINE, PRODUCT

RUNS = 100
NAMES = {BASELINE: "paper_monte_carlo", PRODUCT: "monte_carlo"}
BEGIN = "<!-- campaigns: made by flotilla results -->\n"
_PERCENTS = (50.0, 95.0)


class MonteCarlo(NamedTuple):
    """A campaign's published figures; distances: median and 95th percentile from 100 s on.

    `ended`: number of runs by ending; `late_m` (N, 2): distances of each boat over all runs;
    `runs_m` (R, N, 2): distances in each run.
    """

    scenario: str
    ended: Counter[str]
    late_m: list[list[float]]
    runs_m: list[list[list[float]]]


def sail(out: Path, workers: int) -> list[Campaign]:
    """Sail the campaigns into folders of `out`; ValueError if one does not finish."""
    return [_sail(name, out / name, workers) for name in NAMES.values()]


def _sail(name: str, folder: Path, workers: int) -> Campaign:
    given = ["campaign", name, "--runs", str(RUNS), "--workers", str(workers), "--out", str(folder)]
    options = argparse.Namespace(
        scenario=name, out=folder, seed=None, law=None, param=[], set=[], runs=RUNS, run=None,
        workers=workers, scheduler=None,
    )  # fmt: skip
    pool.prepare(["sil.campaign.work"])
    status = campaign.main(options, given, time.perf_counter())
    if status != 0:
        raise ValueError(f"the campaign {name} was not finished: exit status {status}")
    return finished.read(folder)


def picture(campaign: Campaign) -> bytes:
    """PNG of the distances from the slots over all runs, after the paper's Fig. 2."""
    sampled = samples.read(campaign)
    return png(campaign_report.errors_figure(campaign, sampled, nominal.read(campaign.folder)))


def told(campaign: Campaign) -> MonteCarlo:
    """The published figures of a campaign."""
    late_m = samples.read(campaign).late_percentiles(_PERCENTS)
    runs_m = np.stack([campaign.cells["error_p50_m"], campaign.cells["error_p95_m"]], axis=-1)
    ended = Counter(campaign.outcome.tolist())
    return MonteCarlo(campaign.scenario, ended, late_m.tolist(), runs_m.tolist())


def for_page(campaigns: Sequence[MonteCarlo]) -> str:
    """Table of each boat's percentiles, in Markdown, and a picture of each campaign."""
    heads = (f"`{campaign.scenario}`: {x}" for campaign in campaigns for x in ("median", "95 %"))
    lines = [f"| boat | {' | '.join(heads)} |", "|--:" * (1 + 2 * len(campaigns)) + "|"]
    boats = zip(*(campaign.late_m for campaign in campaigns), strict=True)
    for boat, levels in enumerate(boats, start=1):
        cells = (f"{level:.3f} m" for percentiles in levels for level in percentiles)
        lines.append(f"| {boat} | {' | '.join(cells)} |")
    for name, ended, _, _ in campaigns:
        outcomes = (finished.OK, finished.DIVERGED, finished.FAILED)
        counts = ", ".join(f"{ended[outcome]} {outcome}" for outcome in outcomes)
        about = f"`{name}`: distances from the slot over {ended.total()} runs"
        lines += ["", f"![{about}](../results/{name}.png)", "", f"`{name}`: {counts}."]
    return "\n".join(lines)
