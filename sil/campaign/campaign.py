# SPDX-License-Identifier: MIT
"""A campaign from its beginning to its tables."""

import argparse
import shlex
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import flotilla
from rich.console import Console
from rich.markup import escape

from sil.campaign import runner, summary
from sil.campaign.aside import in_a_process, nominal_run
from sil.campaign.campaign_files import Folder, Identity
from sil.campaign.progress import bar
from sil.campaign.sampling import Sampler
from sil.campaign.work import OtherCodeError, Share, ShareResult, code
from sil.common.out_folder import claim
from sil.lockstep.policies import PolicyViolationError
from sil.lockstep.start import StartError
from sil.lockstep.world import check
from sil.scenario import arguments, scenario
from sil.scenario.scenario import Scenario

_INTERRUPTED = 130
BATCH, TRACES_BYTES = 25, 200e6
"""Greatest number of runs in a batch, and size of its traces; results do not depend on them."""


@dataclass(frozen=True)
class Campaign:
    """A campaign to sail: its scenario, its folder and its command line."""

    sampler: Sampler
    identity: Identity
    folder: Folder
    command: str

    @classmethod
    def of(cls, options: argparse.Namespace, command: str) -> "Campaign":
        """The campaign of a command line; ValueError if the options are invalid."""
        source = scenario.read(options.scenario, options.set, options.law)
        sampler = Sampler(source, options.seed)
        if sampler.nominal.leader.voyage_room_m is not None:
            raise ValueError(
                f"{sampler.nominal.name}: a campaign judges boats by their slots, and the voyage "
                "that measures a hull has none; sail it with: flotilla run"
            )
        name, document = sampler.nominal.name, source.document
        parameters = arguments.parameters_of(options.param)
        if both := sampler.parameters & parameters.keys():
            raise ValueError(f"--param {', '.join(sorted(both))}: the scenario varies it")
        identity = Identity(name, document, parameters, sampler.seed, options.runs, code())
        return cls(sampler, identity, Folder(options.out or Path("out/campaign") / name), command)


def main(options: argparse.Namespace, given: Sequence[str], began_s: float) -> int:
    """Sail the campaign of a command line. It began at `began_s` by time.perf_counter."""
    console = Console()
    command = shlex.join(["flotilla", *given])
    try:
        campaign = Campaign.of(options, command)
        if options.run is None:
            _sail(campaign, options, began_s, console)
        else:
            _replay(campaign, options.run, console)
    except KeyboardInterrupt:
        console.print(f"interrupted; to go on: {escape(command)}", soft_wrap=True)
        return _INTERRUPTED
    except PolicyViolationError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except (OSError, ValueError, StartError, OtherCodeError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


def _replay(campaign: Campaign, run: int, console: Console) -> None:
    """Sail one run alone, with all files that `flotilla run` leaves."""
    # workers of a campaign do not need the modules that draw pictures
    from sil.campaign import campaign_report, rerun  # noqa: PLC0415
    from sil.report import one_run as single  # noqa: PLC0415

    folder = campaign.folder.path
    rerun.check(folder, campaign.identity, run)
    out, parameters = rerun.place(folder, run), dict(campaign.identity.parameters)
    single.run(campaign.sampler.scenario(run), out, parameters, campaign.command, console)
    if rerun.is_finished(folder):
        console.print(rerun.told(folder, run))
        campaign_report.write(folder)


def _sail(
    campaign: Campaign, options: argparse.Namespace, began_s: float, console: Console
) -> None:
    identity, folder, sampler = campaign.identity, campaign.folder, campaign.sampler
    # Report impossible runs before any is sailed.
    check(sampler.nominal, dict(identity.parameters))
    for run in range(identity.runs):
        sampler.scenario(run)
    if not folder.is_begun():
        claim(folder.path, "campaign.json", identity.scenario)
    with folder.alone():
        say = partial(_say, console)
        results = folder.begin(identity, campaign.command, say)
        with nominal_run(folder.path, sampler.nominal, identity.parameters, say):
            effort = _sail_left(campaign, options, results, console)
        _finish(campaign, results, effort, began_s, console)


def _say(console: Console, text: str) -> None:
    console.print(escape(text), soft_wrap=True)


def _sail_left(
    campaign: Campaign, options: argparse.Namespace, results: list[ShareResult], console: Console
) -> summary.Effort:
    """Sail the runs that are not among `results`, and add them."""
    identity, folder, sampler = campaign.identity, campaign.folder, campaign.sampler
    done = {run.run for result in results for run in result.runs}
    left = [run for run in range(identity.runs) if run not in done]

    def batches(least: int) -> list[Share]:
        size = min(_most_runs(sampler.nominal), -(-len(left) // least))
        return [
            Share(tuple(left[i : i + size]), sampler, identity.parameters, identity.code)
            for i in range(0, len(left), max(1, size))
        ]

    effort = summary.Effort()
    with bar(sampler.nominal, identity.runs, len(done), console) as advance:

        def note(result: ShareResult) -> None:
            folder.keep(result)
            results.append(result)
            effort.add(result)
            advance(len(result.runs))

        if options.scheduler is None:
            effort.cores = options.workers
            runner.locally(batches(options.workers), options.workers, note)
        else:
            say = partial(_say, console)
            effort.cores = runner.on_cluster(batches, options.scheduler, note, say)
    return effort


def _most_runs(nominal: Scenario) -> int:
    """The greatest number of runs of a scenario in one batch."""
    ticks, boats = nominal.duration_s * nominal.rate_hz, len(nominal.boat)
    # eta and nu of every agent, tau of every boat: the arrays in sil.lockstep.trace.Tracer
    trace_bytes = 8.0 * ticks * (6 * (boats + 1) + 2 * boats)
    return max(1, min(BATCH, int(TRACES_BYTES / trace_bytes)))


def _finish(
    campaign: Campaign,
    results: Sequence[ShareResult],
    effort: summary.Effort,
    began_s: float,
    console: Console,
) -> None:
    """Write the tables and campaign.json, and print a summary."""
    # modules that workers do not need, imported while the runs are sailed
    from sil.campaign import (  # noqa: PLC0415
        campaign_report,
        table,
        worst,
    )

    folder, sampler = campaign.folder, campaign.sampler
    sailed = {run.run: run for result in results for run in result.runs}
    runs = [sailed[run] for run in sorted(sailed)]
    rows = table.table(runs, len(sampler.nominal.boat), flotilla.STATES)
    for name, content in (
        ("table", rows),
        ("draws", table.draws(sampler, campaign.identity.runs)),
        ("seconds", table.seconds(runs)),
        ("envelopes", table.envelopes(runs)),
    ):
        folder.write(f"{name}.parquet", table.parquet(content))
    effort.wall_s = time.perf_counter() - began_s
    told = summary.figures(sampler.nominal, runs, effort, table.content_digest(rows))
    folder.write_json(campaign.identity, {"command": campaign.command, **told})
    summary.show(console, sampler.nominal, runs, told)
    if len(sailed) > 1 and len({run.digest for run in sailed.values()} - {None, ""}) == 1:
        name = sampler.nominal.name
        _say(console, f"all runs of {name} are identical: see [[vary]] in sil/docs/CAMPAIGNS.md")
    parameters = dict(campaign.identity.parameters)
    with in_a_process(worst.write, folder.path, sampler, parameters) as worst_sailed:
        campaign_report.write(folder.path, worst_sailed)
    folder.finish()
    _say(console, f"results: {folder.path}")
