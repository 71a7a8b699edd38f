# SPDX-License-Identifier: MIT
"""Sails all claims with the paper's law and the product's, and judges them."""

import argparse
import json
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import (
    BarColumn,
    MofNCompleteColumn,
    Progress,
    TextColumn,
    TimeElapsedColumn,
    TimeRemainingColumn,
)

from sil.campaign.finished import Campaign
from sil.common import files
from sil.report import comparison
from sil.results import (
    SEEDS,
    published,
    results_campaigns,
    results_fleets,
    results_readme,
    results_scalar,
    results_table,
)
from sil.results.claims import BASELINE, CLAIMS, LAWS, PRODUCT
from sil.results.published import PICTURES, Published
from sil.results.results_table import PublishedBound
from sil.results.sailing import Job, Outcome, sail_all

_INTERRUPTED = 130


def main(options: argparse.Namespace) -> int:
    """Run the command; returns its exit status.

    0; 1 if a bound is missed or a run failed; 2 after a mistake of the caller; 130 if interrupted.
    """
    console = Console()
    unknown = [name for name in options.only or () if name not in CLAIMS]
    if unknown:
        raise ValueError(f"--only {unknown[0]}: there are {', '.join(CLAIMS)}")
    try:
        if options.scalar:
            return _compare(options, console)
        if options.fleets:
            outcomes = _sail(results_fleets.jobs(), options.workers, console)
            console.print(results_fleets.for_terminal(outcomes))
            text = results_fleets.encoded(outcomes)
            noted = results_fleets.decoded(text)  # so that the page agrees with the file's digits
            _write(
                {
                    results_fleets.FIGURES: text,
                    results_fleets.PAGE: results_fleets.page(noted).encode(),
                }
            )
            return 0 if all(row.reached for row in results_fleets.rows(noted)) else 1
        options.out.mkdir(parents=True, exist_ok=True)
        campaigns = []
        if _whole(options):
            published.check_places()  # report a missing place before sailing for minutes
            campaigns = results_campaigns.sail(options.out, options.workers)
        outcomes = _sail(jobs(options), options.workers, console)
        table = results_table.rows(outcomes)
        console.print(results_table.for_terminal(table))
        pictures = _pictures(outcomes)
        content = {options.out / "results.json": _json(table, outcomes)}
        content |= {options.out / name: picture for name, picture in pictures.items()}
        if _whole(options):
            content |= _published(outcomes, campaigns)
            content |= {PICTURES / name: picture for name, picture in pictures.items()}
        _write(content)
    except KeyboardInterrupt:
        console.print("interrupted")
        return _INTERRUPTED
    except (OSError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    pages = ", the project's pages" if _whole(options) else ""
    written = f"written: {options.out}/results.json, pictures{pages}"
    console.print(written, soft_wrap=True, markup=False)
    return 0 if all(row.reached for row in table) else 1


def _compare(options: argparse.Namespace, console: Console) -> int:
    """Compare two scalars; exit status 1 if a figure differs from float's, else 0."""
    in_float, other = (
        _sail(jobs(options, (f"scalar='{scalar}'",)), options.workers, console)
        for scalar in ("float", options.scalar)
    )
    found = results_scalar.pairs(in_float, other)
    console.print(results_scalar.for_terminal(options.scalar, found))
    return 0 if all(pair.alike for pair in found) else 1


def _whole(options: argparse.Namespace) -> bool:
    """Whether the options sail everything that the pages publish."""
    return not options.only and not options.set and options.seeds == SEEDS


def jobs(options: argparse.Namespace, overrides: tuple[str, ...] = ()) -> list[Job]:
    """The jobs that the command's options select."""
    seeds = range(1, options.seeds + 1)
    return [
        Job(name, law, seed, (*options.set, *overrides))
        for name, claim in CLAIMS.items()
        if not options.only or name in options.only
        for law in LAWS
        for seed in (seeds if claim.many_seeds else (None,))
    ]


def _sail(jobs: Sequence[Job], workers: int, console: Console) -> list[Outcome]:
    columns = (BarColumn(), MofNCompleteColumn(), TimeElapsedColumn(), TimeRemainingColumn())
    # estimate the time left from many runs, not from the last seconds
    bar = Progress(TextColumn("sailing"), *columns, console=console, speed_estimate_period=600.0)
    with bar:
        task = bar.add_task("", total=len(jobs))

        def tell(outcome: Outcome) -> None:
            bar.advance(task)
            if outcome.failure:
                console.print(f"[bold red]{outcome.job}: {escape(outcome.failure)}")

        return sail_all(jobs, workers, tell)


def _pictures(outcomes: Sequence[Outcome]) -> dict[str, bytes]:
    names = dict.fromkeys(outcome.job.scenario for outcome in outcomes)
    pictures = {f"{name}.png": picture(name, outcomes) for name in names}
    return {name: content for name, content in pictures.items() if content}


def _published(outcomes: Sequence[Outcome], campaigns: Sequence[Campaign]) -> dict[Path, bytes]:
    told = [results_campaigns.told(campaign) for campaign in campaigns]
    figures = published.encoded(Published([*outcomes], told, results_readme.sail()))
    # decode the file's own digits, so that the pages agree with it
    pages = published.pages(published.decoded(figures))
    return {
        published.FIGURES: figures,
        **{
            PICTURES / f"{campaign.scenario}.png": results_campaigns.picture(campaign)
            for campaign in campaigns
        },
        **{path: text.encode() for path, text in pages.items()},
    }


def picture(name: str, outcomes: Sequence[Outcome]) -> bytes | None:
    """PNG of a scenario's runs; None if the product has none."""
    traces = {
        law: [o.trace for o in outcomes if o.job[:2] == (name, law) and not o.failure]
        for law in LAWS
    }
    if not traces[PRODUCT]:
        return None
    claim = CLAIMS[name]
    baseline, product = traces[BASELINE], traces[PRODUCT]
    return comparison.png(comparison.picture(name, claim.limit_m, claim.map_s, baseline, product))


def _json(table: Sequence[PublishedBound], outcomes: Sequence[Outcome]) -> bytes:
    bounds = [
        {
            "scenario": row.scenario,
            "figure": row.bound.key,
            "paper": row.baseline,
            "product": row.product,
            "to_reach": row.bound.to_reach,
            "reached": row.reached,
        }
        for row in table
    ]
    runs = [
        {
            "scenario": outcome.job.scenario,
            "law": outcome.job.law,
            "seed": outcome.job.seed,
            "overrides": outcome.job.overrides,
            "failure": outcome.failure or None,
            "digest": outcome.digest,
            "figures": outcome.figures,
            "boats": outcome.boats,
            "min_separation_m": outcome.min_separation_m,
        }
        for outcome in outcomes
    ]
    text = json.dumps(files.plain({"bounds": bounds, "runs": runs}), indent=1, allow_nan=False)
    return f"{text}\n".encode()


def _write(content: Mapping[Path, bytes]) -> None:
    """Write files, each atomically."""
    for path, data in content.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        files.replace(path, data)
