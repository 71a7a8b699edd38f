# SPDX-License-Identifier: MIT
"""python -m sil campaign: many runs of a scenario, each with its own draws, and what they show."""

import argparse
import time
from collections.abc import Sequence
from typing import Any

from sil.common import pool
from sil.scenario import arguments


def add_to(commands: Any) -> None:
    """Add the command to argparse's subparsers."""
    command = commands.add_parser(
        "campaign", help="sail a scenario many times, each run with its own draws of [[vary]]"
    )
    arguments.add_to(command, out="folder of the results (out/campaign/SCENARIO)")
    command.add_argument("--runs", type=arguments.count, default=100, metavar="N", help="(100)")
    arguments.add_workers_to(command)
    command.add_argument(
        "--scheduler", metavar="ADDRESS", help="of a Dask cluster that sails them: tcp://HOST:PORT"
    )
    command.add_argument(
        "--run", type=int, metavar="K", help="sail run K alone, with full trace, into DIR/runs/K"
    )


def main(options: argparse.Namespace, given: Sequence[str]) -> int:
    """Exit status: 0, 2 for a mistake of the caller, 130 interrupted; `given` is what he typed.

    A run that diverges or fails is told, and changes no exit status.
    """
    began_s = time.perf_counter()
    if options.run is None and options.scheduler is None:
        pool.prepare(["sil.campaign.warm"])
    # While the workers' imports go on, this process's.
    from sil.campaign import campaign  # noqa: PLC0415

    return campaign.main(options, given, began_s)
