# SPDX-License-Identifier: MIT
"""Tests whether campaign B is worse than campaign A by more than chance."""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from rich.console import Console
from rich.markup import escape

from sil.campaign import campaign_figures, change, comparison_table, finished, pairs
from sil.campaign.change import Change
from sil.campaign.pairs import Pairing
from sil.common import files


def main(options: argparse.Namespace) -> int:
    """Compare two campaigns and print the result; returns the exit status.

    0; 1 if any figure of B is worse; 2 after a mistake of the caller.
    """
    try:
        pairing = pairs.pair(finished.read(options.a), finished.read(options.b))
        _need_runs(pairing)
        found = campaign_figures.compare(pairing.a, pairing.b, paired=pairing.paired)
        if options.json:
            files.replace(options.json, _json(pairing, found))
    except (OSError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    _show(Console(), pairing, found)
    return 1 if _named(found, "worse") else 0


def _need_runs(pairing: Pairing) -> None:
    """ValueError if there are too few runs to distinguish change from chance."""
    for campaign in (pairing.a, pairing.b):
        count = campaign.runs.size
        if count < campaign_figures.LEAST_RUNS:
            what = f"{count} runs of {campaign.folder} can be compared"
            raise ValueError(
                f"{what}; at least {campaign_figures.LEAST_RUNS} are needed: sail more, by --runs"
            )


def _named(found: Mapping[str, Change], verdict: str) -> list[str]:
    return [key for key, one in found.items() if one.verdict == verdict]


def _show(console: Console, pairing: Pairing, found: Mapping[str, Change]) -> None:
    for name, campaign in (("A", pairing.a), ("B", pairing.b)):
        about = f"{campaign.scenario}, {campaign.runs.size} runs, seed {campaign.header['seed']}"
        console.print(f"{name}: {escape(str(campaign.folder))}: {about}", soft_wrap=True)
    for difference in pairing.differences:
        console.print(f"   {escape(difference)}", soft_wrap=True)
    console.print(pairing.about, soft_wrap=True)
    console.print(comparison_table.table(found))
    console.print(comparison_table.note(paired=pairing.paired), style="dim")
    worse, better = _named(found, "worse"), _named(found, "better")
    if worse:
        console.print(f"[bold red]B is worse: {', '.join(worse)}")
    if better:
        console.print(f"[bold green]B is better: {', '.join(better)}")
    if not worse and not better:
        console.print("no change that is certain" if not pairing.same else "the same, bit for bit")


def _json(pairing: Pairing, found: Mapping[str, Change]) -> bytes:
    """The comparison as JSON; infinite and missing figures are null."""
    entries: Sequence[Mapping[str, Any]] = [
        {"figure": key, "what": campaign_figures.WHAT[key], **asdict(one)}
        for key, one in found.items()
    ]
    content = {
        "a": str(pairing.a.folder),
        "b": str(pairing.b.folder),
        "scenario": pairing.a.scenario,
        "runs": [int(pairing.a.runs.size), int(pairing.b.runs.size)],
        "paired": pairing.paired,
        "false_alarms": change.FALSE_ALARMS,
        "margin": change.MARGIN,
        "figures": entries,
        "worse": _named(found, "worse"),
        "better": _named(found, "better"),
    }
    return f"{json.dumps(files.plain(content), indent=1, allow_nan=False)}\n".encode()
