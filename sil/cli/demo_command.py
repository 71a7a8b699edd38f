# SPDX-License-Identifier: MIT
"""Boat 1 sails a plan and three boats follow in a diamond; the report is out/demo/report.html.

With --live they sail in real time, a flotillad process each, and a page in the browser shows them,
and the plan, and, in a terminal, plays back what it heard when they have sailed.
Further options go to `flotilla run`, or with --live to `flotilla live`.
"""

import argparse
import signal
import subprocess
import sys
from collections.abc import Sequence
from contextlib import suppress

EXAMPLES = ("flotilla demo", "flotilla demo --live", "flotilla demo --law product")


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("--live", action="store_true", help="in real time, shown in the browser")


def main(options: argparse.Namespace, given: Sequence[str]) -> int:
    """Sail it."""
    from sil.cli.main import main as flotilla

    others = [text for text in given[1:] if text != "--live"]

    if not options.live:
        return flotilla(["run", "lead", "--out", "out/demo", *others])
    from sil.live.live_world import build

    print("building flotillad", flush=True)
    build(print)
    view = subprocess.Popen([sys.executable, "-m", "sil", "view", "mcast:"])
    try:
        live = ["live", "lead", "--bus", "mcast:0", "--mavlink", "mcast:", "--out", "out/live"]
        status = flotilla([*live, "--param", "SR_SLOW=5", *others])
        if status == 0 and sys.stdin.isatty():
            view.send_signal(signal.SIGUSR1)
            print("the run is over; its page plays it back until Ctrl-C", flush=True)
            with suppress(KeyboardInterrupt):
                view.wait()
        return status
    finally:
        view.terminate()
        view.wait()
