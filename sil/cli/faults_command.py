# SPDX-License-Identifier: MIT
"""Sails the matrix of faults, each against its limits, or random faults for hours.

Exit status: 0 if all limits were kept, 1 if not, 2 after a mistake of the caller, 130 if
interrupted.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from sil.scenario import arguments

EXAMPLES = (
    "flotilla faults",
    "flotilla faults --only leader",
    "flotilla faults --soak 24 --seed 1",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "--out",
        type=arguments.nonempty_path,
        default=Path("out/faults"),
        help="folder of the results (out/faults)",
    )
    parser.add_argument("--only", metavar="NAME", help="sail only rows whose name contains NAME")
    parser.add_argument(
        "--live",
        action="store_true",
        help="also sail the live rows: flotillad on a vcan, in real time",
    )
    parser.add_argument("--soak", metavar="HOURS", type=float, help="sail random faults for HOURS")
    parser.add_argument("--seed", type=int, metavar="N", help="seed of the soak (1)")


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Sail the matrix or the soak."""
    from rich.console import Console

    from sil.faults import examination
    from sil.faults.live_matrix import NoVcanError
    from sil.lockstep.start import StartError

    if options.soak is None and options.seed is not None:
        raise ValueError("--seed needs --soak: the matrix has no random numbers to choose")
    if options.soak is not None and (options.only is not None or options.live):
        raise ValueError("--soak sails random faults: leave out --only and --live")
    seed = 1 if options.seed is None else options.seed
    try:
        if options.soak is not None:
            return examination.soak_for(options.soak, seed, Console())
        return examination.sail(options.out, options.only, Console(), live=options.live)
    except (StartError, NoVcanError) as error:
        raise ValueError(str(error)) from None
