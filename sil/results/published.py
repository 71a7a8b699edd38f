# SPDX-License-Identifier: MIT
"""The published figures, kept in results/figures.json run by run.

The pages' tables are generated from this file, and tests compare it with their own runs.
"""

import json
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from sil import ROOT
from sil.results import results_campaigns, results_readme, results_table
from sil.results.figures_json import line, numbers
from sil.results.results_campaigns import MonteCarlo
from sil.results.results_readme import Measured
from sil.results.results_table import PublishedBound
from sil.results.sailing import Job, Outcome

PAGE = ROOT / "sil" / "docs" / "RESULTS.md"
MEASUREMENTS = ROOT / "sil" / "docs" / "MEASUREMENTS.md"
PICTURES = ROOT / "sil" / "results"
FIGURES = PICTURES / "figures.json"


class Published(NamedTuple):
    """All figures: each run of the law's table, the Monte Carlo, the measurements."""

    outcomes: list[Outcome]
    campaigns: list[MonteCarlo]
    measured: Measured

    @property
    def table(self) -> list[PublishedBound]:
        """The law's table."""
        return results_table.rows(self.outcomes)


def encoded(published: Published) -> bytes:
    """Encode as figures.json: one run per line, 6 digits, non-finite numbers as null."""
    runs = [
        {
            "scenario": outcome.job.scenario,
            "law": outcome.job.law,
            "seed": outcome.job.seed,
            "failure": outcome.failure,
            "figures": outcome.figures,
        }
        for outcome in published.outcomes
    ]
    campaigns = ",\n".join(
        f'{{"scenario": {line(name)}, "ended": {line(ended)}, "late_m": {line(late_m)}, '
        f'"runs_m": {_lines(runs_m)}}}'
        for name, ended, late_m, runs_m in published.campaigns
    )
    return (
        f'{{"measured": {line(published.measured)},\n"runs": {_lines(runs)},\n'
        f'"campaigns": [{campaigns}]}}\n'
    ).encode()


def decoded(content: bytes) -> Published:
    """Decode the output of `encoded`."""
    document = json.loads(content)
    outcomes = [
        Outcome(
            Job(run["scenario"], run["law"], run["seed"]),
            run["failure"],
            figures=numbers(run["figures"]),
        )
        for run in document["runs"]
    ]
    campaigns = [
        MonteCarlo(
            one["scenario"],
            Counter(one["ended"]),
            numbers(one["late_m"]),
            numbers(one["runs_m"]),
        )
        for one in document["campaigns"]
    ]
    return Published(outcomes, campaigns, numbers(document["measured"]))


def noted() -> Published:
    """The figures that the project publishes."""
    return decoded(FIGURES.read_bytes())


def pages(published: Published) -> dict[Path, str]:
    """The pages with the figures filled in; ValueError if one lacks the marks for them."""
    table = published.table
    return {
        PAGE: _filled(
            PAGE,
            {
                results_table.BEGIN: results_table.for_page(table),
                results_campaigns.BEGIN: results_campaigns.for_page(published.campaigns),
            },
        ),
        MEASUREMENTS: _filled(
            MEASUREMENTS,
            {
                results_readme.MEASURED_BEGIN: results_readme.for_measured(
                    table, published.measured
                ),
                results_readme.LAW_BEGIN: results_readme.for_law(table, published.campaigns),
            },
        ),
    }


def check_places() -> None:
    """ValueError if a page lacks the marks for its figures."""
    _filled(PAGE, dict.fromkeys((results_table.BEGIN, results_campaigns.BEGIN), ""))
    _filled(
        MEASUREMENTS, dict.fromkeys((results_readme.MEASURED_BEGIN, results_readme.LAW_BEGIN), "")
    )


def _filled(path: Path, sections: dict[str, str]) -> str:
    text = path.read_text(encoding="utf-8")
    for begin, content in sections.items():
        text = results_table.between(text, begin, content)
    return text


def _lines(values: Iterable[Any]) -> str:
    return "[\n" + ",\n".join(map(line, values)) + "]"
