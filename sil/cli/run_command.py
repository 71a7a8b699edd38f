# SPDX-License-Identifier: MIT
"""Sails a scenario in lockstep, as fast as possible, and leaves a report.

Exit status: 0; 1 if the verdict is red (a boat stopped, or two boats came nearer than a hull's
length) or a boat broke a rule of the firmware; 2 after a mistake of the caller.
"""

import argparse
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sil.common.out_folder import claim
from sil.scenario import arguments

if TYPE_CHECKING:
    from rich.console import Console

    from sil.scenario.scenario import Scenario

EXAMPLES = (
    "flotilla run diamond",
    "flotilla run diamond --seed 2 --param LAW_KX=0.3 --set link.delay_s=0.1 --out out/late",
    "flotilla run my_scenario.toml --law paper",
)
_CHAIN = 5


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_to(parser, out="folder of the results (out/SCENARIO)")
    parser.add_argument(
        "--mcap", action="store_true", help="also write run.mcap, for Foxglove, Lichtblick, Rerun"
    )


def main(options: argparse.Namespace, given: Sequence[str]) -> int:
    """Sail the scenario; `given`: the command line as the caller typed it."""
    from rich.console import Console

    from sil.lockstep.policies import PolicyViolationError
    from sil.lockstep.start import StartError
    from sil.report import headline, one_run
    from sil.scenario import scenario

    overrides = list(options.set)
    if options.seed is not None:
        overrides.append(f"seed={options.seed}")
    chosen = scenario.load(options.scenario, overrides, options.law)
    out = claim(options.out or Path("out") / chosen.name, "summary.json", chosen.name)
    parameters = arguments.parameters_of(options.param)
    console = Console()
    try:
        _tell_depth(chosen, parameters, console)
        repeat = shlex.join(["flotilla", *given])
        summary = one_run.run(chosen, out, parameters, repeat, console)
        _leave_mcap(out, options.mcap, console)
        leave_motion(chosen, out, parameters, console)
    except PolicyViolationError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except StartError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return int(headline.of_run(summary).level == "bad")


def _tell_depth(chosen: "Scenario", parameters: dict[str, float], console: "Console") -> None:
    """Warn of a chain of boats that is deeper than certified; up to four are not checked."""
    if len(chosen.boat) < _CHAIN:
        return
    from sil.certificate.probe import deepest

    if len(deepest(chosen)) < _CHAIN:
        return
    from sil.certificate.chain import chain, too_deep
    from sil.certificate.references import references
    from sil.lockstep.start import RunError

    try:
        for reference in references(chosen):
            if reference.kind == "rest":
                continue
            found = chain(chosen, reference, parameters, most=len(deepest(chosen)))
            if not found.holds:
                console.print(f"[bold red]warning: not certified: {too_deep(found)}")
                return
    except (RunError, ValueError):
        return  # the run itself reports the error


def leave_motion(
    chosen: "Scenario", out: Path, parameters: dict[str, float], console: "Console"
) -> None:
    """Write the table of a voyage that measures a hull; remove an earlier run's table."""
    (out / "motion1.csv").unlink(missing_ok=True)
    if chosen.leader.voyage_room_m is None:
        return
    from sil.logs import own_motion

    own = {"ESC_PORT": 0.0, "ESC_STBD": 1.0, **chosen.firmware_parameters(chosen.boat[0])}
    own.update(parameters)
    path = own_motion.leave(out, 1, round(own["ESC_PORT"]), round(own["ESC_STBD"]))
    console.print(f"motion and commands: {path}", soft_wrap=True, markup=False)


def _leave_mcap(out: Path, wanted: bool, console: "Console") -> None:
    """Write the log of the run in `out`, or remove an earlier run's log if `wanted` is false."""
    path = out / "run.mcap"
    if not wanted:
        path.unlink(missing_ok=True)
        return
    from rich.progress import Progress

    from sil.logs import run_folder

    with Progress(console=console) as shown:
        task = shown.add_task(path.name, total=1.0)
        run_folder.convert(out, path, lambda share: shown.update(task, completed=share))
    console.print(f"log: {path}", soft_wrap=True, markup=False)
