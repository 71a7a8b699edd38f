# SPDX-License-Identifier: MIT
"""Sails the matrix of faults, each against its limits, or random faults for hours.

Exit status: 0 all limits kept, 1 not all, 2 for a mistake of the caller, 130 interrupted.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

EXAMPLES = (
    "flotilla faults",
    "flotilla faults --only leader",
    "flotilla faults --soak 24 --seed 1",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--out", type=Path, default=Path("out/faults"), help="(out/faults)")
    parser.add_argument("--only", metavar="NAME", help="rows whose names have this in them")
    parser.add_argument(
        "--live", action="store_true", help="the live rows as well: flotillad on a vcan, real time"
    )
    parser.add_argument("--soak", metavar="HOURS", type=float, help="random faults for so long")
    parser.add_argument("--seed", type=int, default=1, help="of the soak's random numbers (1)")


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Sail them."""
    from rich.console import Console

    from sil.faults import examination
    from sil.faults.live_matrix import NoVcanError
    from sil.lockstep.start import StartError

    try:
        if options.soak is not None:
            return examination.soak_for(options.soak, options.seed, Console())
        return examination.sail(options.out, options.only, Console(), live=options.live)
    except (StartError, NoVcanError) as error:
        raise ValueError(str(error)) from None
