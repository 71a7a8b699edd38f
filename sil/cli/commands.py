# SPDX-License-Identifier: MIT
"""python -m sil run and live: one scenario, in lockstep or in real time."""

import argparse
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import can
from rich.console import Console
from rich.progress import Progress

from sil.certificate.chain import chain, too_deep
from sil.certificate.probe import deepest
from sil.certificate.references import references
from sil.lockstep.policies import PolicyViolationError
from sil.lockstep.start import RunError, StartError
from sil.logs import run_folder
from sil.report.one_run import live, run
from sil.scenario import arguments, scenario

_CHAIN = 4


def add_to(commands: Any) -> None:
    """Add the commands to argparse's subparsers."""
    lockstep = commands.add_parser("run", help="sail a scenario in lockstep, as fast as it goes")
    in_real_time = commands.add_parser(
        "live", help="sail a scenario in real time, a flotillad process a boat"
    )
    for command in (lockstep, in_real_time):
        arguments.add_to(command, out="folder of the results (out/SCENARIO)")
    lockstep.add_argument(
        "--mcap", action="store_true", help="leave run.mcap too, for Foxglove, Lichtblick, Rerun"
    )
    in_real_time.add_argument(
        "--bus",
        required=True,
        metavar="mcast:N|socketcan:NAMEn",
        help="bus of boat 1, as mcast:0 or socketcan:vcan0; boat i takes the next one",
    )
    in_real_time.add_argument(
        "--mavlink",
        metavar="mcast:[GROUP:PORT[:ADDRESS]]|udpout:HOST:PORT",
        help="repeat all that is said over the radio there, for tools/view and ground stations",
    )
    in_real_time.add_argument("--duration", type=float, help="seconds (the scenario's)")


def main(options: argparse.Namespace, given: Sequence[str]) -> int:
    """Exit status: 0, 1 for a boat that broke a rule, 2 for a mistake of the caller, in one line.

    `given` is what he typed.
    """
    overrides = list(options.set)
    if options.seed is not None:
        overrides.append(f"seed={options.seed}")
    if options.command == "live" and options.duration is not None:
        overrides.append(f"duration_s={options.duration}")
    try:
        chosen = scenario.load(options.scenario, overrides, options.law)
        out = options.out or Path("out") / chosen.name
        parameters = arguments.parameters_of(options.param)
        repeat = shlex.join(["python", "-m", "sil", *given])
        if options.command == "run":
            _tell_depth(chosen, parameters, Console())
            run(chosen, out, parameters, repeat, Console())
        else:
            live(chosen, options.bus, out, parameters, repeat, Console(), options.mavlink)
        _leave_mcap(out, options.command == "run" and options.mcap, Console())
    except PolicyViolationError as error:
        print(f"error: {error}", file=sys.stderr)
        return 1
    except (ValueError, OSError, StartError, can.CanError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


def _tell_depth(chosen: scenario.Scenario, parameters: dict[str, float], console: Console) -> None:
    """Warn of a chain of boats that is deeper than certified; three in a line are not looked at."""
    if len(deepest(chosen)) < _CHAIN:
        return
    try:
        for reference in references(chosen):
            if reference.kind == "rest":
                continue
            found = chain(chosen, reference, parameters, most=len(deepest(chosen)))
            if not found.holds:
                console.print(f"[bold red]warning: not certified: {too_deep(found)}")
                return
    except (RunError, ValueError):
        return  # the run itself says it


def _leave_mcap(out: Path, wanted: bool, console: Console) -> None:
    """Write the log of the run in `out`; unwanted, none of an earlier run stays there."""
    path = out / run_folder.NAME
    if not wanted:
        path.unlink(missing_ok=True)
        return
    with Progress(console=console) as shown:
        task = shown.add_task(run_folder.NAME, total=1.0)
        run_folder.convert(out, path, lambda share: shown.update(task, completed=share))
    console.print(f"log: {path}", soft_wrap=True)
