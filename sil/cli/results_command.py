# SPDX-License-Identifier: MIT
"""Sails all that the project publishes, the paper's law beside the product's; renews its pages.

Exit status: 0, 1 where a bound is missed or a run failed, 2 for a mistake of the caller, 130
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
        help="this scenario; repeatable. The project's pages are left as they are",
    )
    parser.add_argument(
        "--seeds", type=arguments.count, default=SEEDS, metavar="N", help=f"of mismatch ({SEEDS})"
    )
    arguments.add_workers_to(parser)
    parser.add_argument(
        "--out", type=Path, default=Path("out/results"), metavar="DIR", help="(out/results)"
    )
    parser.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="a key of every scenario; repeatable",
    )
    parser.add_argument(
        "--scalar",
        choices=("double", "q16"),
        help="in float and in this arithmetic: where do they differ? nothing is written",
    )
    parser.add_argument(
        "--fleets",
        action="store_true",
        help="long lines, bad radios and unknown hulls, case by case; nothing is written",
    )


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Sail them."""
    from sil.results import results

    return results.main(options)
