# SPDX-License-Identifier: MIT
"""Sails Flotilla and its rivals along four routes, in two weathers, and prints a table.

Rivals: line-of-sight guidance (ILOS, ALOS), steering as ArduPilot's Rover documents it with its
Follow, and nonlinear model-predictive control (NMPC). All have the same hull, sensors, propellers
and rounded plan.
"""

import argparse
from collections.abc import Sequence

EXAMPLES = (
    "flotilla rivals",
    "flotilla rivals --only ILOS",
    "flotilla rivals --write    # into sil/docs/MEASUREMENTS.md",
    "flotilla rivals --tune ALOS",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "--only", metavar="NAME", help="sail only Flotilla, ILOS, ALOS, Rover or NMPC"
    )
    parser.add_argument("--write", action="store_true", help="renew the page of measurements")
    parser.add_argument(
        "--tune", metavar="NAME", help="try a grid of gains of NAME; prints the best first"
    )


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Sail Flotilla and its rivals."""
    from rich.console import Console

    from sil.rivals import rival_table
    from sil.rivals.rivals import OURS, RIVALS, tune
    from sil.rivals.routes import ROUTES

    everyone = (OURS, *RIVALS)
    for given, allowed in ((options.only, everyone), (options.tune, RIVALS)):
        if given is not None and given not in allowed:
            raise ValueError(f"{given}: unknown; choose from {', '.join(allowed)}")
    if options.write and options.only:
        raise ValueError("--write needs all rivals: leave out --only")
    if options.tune:
        for mean_m, gains in tune(options.tune, list(ROUTES)):
            print(f"{mean_m:.4f} m", *gains)
        return 0
    chosen = everyone if options.only is None else (options.only,)
    told = Console(stderr=True)
    made = rival_table.make(chosen, lambda who: told.print(who, style="dim"))
    print(made, end="")
    if options.write:
        rival_table.write(made)
    return 0
