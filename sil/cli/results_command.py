# SPDX-License-Identifier: MIT
"""Sails all scenarios that the project publishes, with the paper's and the product's law.

Then renews the pages of results.

Exit status: 0; 1 if a bound is missed or a run failed; 2 after a mistake of the caller; 130 if
interrupted.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from sil.results import SEEDS
from sil.scenario import arguments

EXAMPLES = (
    "flotilla results",
    "flotilla results --only turning --only straight",
    "flotilla results --fleets",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "--only",
        action="append",
        metavar="NAME",
        help="sail only this scenario; repeatable. The project's pages stay unchanged",
    )
    parser.add_argument(
        "--seeds",
        type=arguments.count,
        default=SEEDS,
        metavar="N",
        help=f"number of seeds with mismatch ({SEEDS})",
    )
    arguments.add_workers_to(parser)
    parser.add_argument(
        "--out",
        type=arguments.nonempty_path,
        default=Path("out/results"),
        metavar="DIR",
        help="folder of the results (out/results)",
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="set a key of every scenario; repeatable",
    )
    parser.add_argument(
        "--scalar",
        choices=("double", "q16"),
        help="compare float with this arithmetic; writes nothing",
    )
    parser.add_argument(
        "--fleets",
        action="store_true",
        help="only long lines, bad radios and Otters: renews their table on the page",
    )


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Sail the scenarios."""
    from sil.results import results

    return results.main(options)
