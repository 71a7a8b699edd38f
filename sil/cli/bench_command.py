# SPDX-License-Identifier: MIT
"""Times the firmware and the simulation and counts instructions.

--live measures flotillad's latencies. --commands measures how long `--help`, a run and a campaign
take, and how much of that time is sailing.

Needs valgrind and the program flotilla_bench. tools/bench provides both, then calls this command.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

EXAMPLES = (
    "tools/bench",
    "flotilla bench --commands",
    "tools/bench --live --seconds 60",
    "tools/bench --live --flood --seconds 30",
    "tools/bench --json out/bench.json",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--json", type=Path, metavar="FILE", help="also write the figures to FILE")
    parser.add_argument(
        "--live", action="store_true", help="measure flotillad's latencies on a live bus"
    )
    parser.add_argument(
        "--flood",
        action="store_true",
        help="with --live: strangers flood one boat's links and tear them; compare it with another",
    )
    parser.add_argument(
        "--commands", action="store_true", help="time the commands that users wait for"
    )
    parser.add_argument("--bus", default="mcast:5", help="bus of boat 1 for --live (mcast:5)")
    parser.add_argument("--seconds", type=float, default=60.0, help="duration of --live (60)")


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Measure and print tables."""
    from rich.console import Console

    if options.commands:
        from sil.bench import command_times

        command_times.tell(Console())
        return 0
    from sil.bench.bench import tell

    if options.flood and not options.live:
        raise ValueError("--flood needs --live")
    live = (options.bus, options.seconds) if options.live else None
    tell(options.json, Console(), live, flood=options.flood)
    return 0
