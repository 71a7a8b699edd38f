# SPDX-License-Identifier: MIT
"""Converts boats' logs, or a run's folder, to an MCAP file for Foxglove, Lichtblick or Rerun.

Takes telemetry logs (*.tlog) and candump logs of `flotillad --log DIR`, or DIR itself, of one boat
or several; or the folder of one run.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

EXAMPLES = ("flotilla convert out/diamond", "flotilla convert boat1/log boat2/log --out both.mcap")


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("logs", nargs="+", type=Path, metavar="TLOG|CANDUMP|FOLDER")
    parser.add_argument(
        "--out", type=Path, metavar="FILE.mcap", help="output file (beside the first log)"
    )


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Convert the logs."""
    from rich.console import Console

    from sil.logs.convert import convert

    convert(options.logs, options.out, Console())
    return 0
