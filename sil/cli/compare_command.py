# SPDX-License-Identifier: MIT
"""Tells whether campaign B is worse than campaign A by more than chance.

Exit status: 0; 1 if any figure of B is worse; 2 after a mistake of the caller.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

EXAMPLES = ("flotilla compare out/campaign/before out/campaign/after",)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("a", type=Path, metavar="A", help="folder of a campaign")
    parser.add_argument(
        "b", type=Path, metavar="B", help="folder of another campaign of the same scenario"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the figures to FILE")


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Compare the campaigns."""
    from sil.campaign import compare

    return compare.main(options)
