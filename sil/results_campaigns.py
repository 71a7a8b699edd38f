# SPDX-License-Identifier: MIT
"""The paper's Monte Carlo with both laws, as the page of results has it."""

import argparse
from collections.abc import Sequence
from pathlib import Path

from sil.campaign import command, finished, nominal, report, samples
from sil.campaign.finished import Campaign
from sil.claims import BASELINE, PRODUCT
from sil.comparison import png

RUNS = 100
NAMES = {BASELINE: "paper_monte_carlo", PRODUCT: "monte_carlo"}
BEGIN = "<!-- campaigns: made by python -m sil results -->\n"
_PERCENTS = (50.0, 95.0)


def sail(out: Path, workers: int) -> list[Campaign]:
    """Sail the campaigns into folders of `out`; ValueError where one cannot be finished."""
    return [_sail(name, out / name, workers) for name in NAMES.values()]


def _sail(name: str, folder: Path, workers: int) -> Campaign:
    parser = argparse.ArgumentParser()
    command.add_to(parser.add_subparsers())
    count = ("--runs", str(RUNS), "--workers", str(workers), "--out", str(folder))
    given = ["campaign", name, *count]
    status = command.main(parser.parse_args(given), given)
    if status != 0:
        raise ValueError(f"the campaign {name} was not finished: exit status {status}")
    return finished.read(folder)


def picture(campaign: Campaign) -> bytes:
    """PNG of the distances from the slots over all runs, after the paper's Fig. 2."""
    sampled = samples.read(campaign)
    return png(report.errors_figure(campaign, sampled, nominal.read(campaign.folder)))


def for_page(campaigns: Sequence[Campaign]) -> str:
    """Table of the percentiles a boat, in Markdown, and a picture of each campaign."""
    heads = (f"`{campaign.scenario}`: {x}" for campaign in campaigns for x in ("median", "95 %"))
    lines = [f"| boat | {' | '.join(heads)} |", "|--:" * (1 + 2 * len(campaigns)) + "|"]
    levels = [samples.read(campaign).late_percentiles(_PERCENTS) for campaign in campaigns]
    for boat in range(campaigns[0].boats):
        cells = (f"{level:.3f} m" for percentiles in levels for level in percentiles[boat])
        lines.append(f"| {boat + 1} | {' | '.join(cells)} |")
    for campaign in campaigns:
        outcomes = campaign.outcome.tolist()
        told = ", ".join(
            f"{outcomes.count(outcome)} {outcome}"
            for outcome in (finished.OK, finished.DIVERGED, finished.FAILED)
        )
        about = f"`{campaign.scenario}`: distances from the slot over {len(outcomes)} runs"
        lines += ["", f"![{about}](results/{campaign.scenario}.png)"]
        lines += ["", f"`{campaign.scenario}`: {told}."]
    return "\n".join(lines)
