# SPDX-License-Identifier: MIT
"""Boat 1 sails a plan and three boats follow in a diamond; the report is out/demo/report.html.

From a terminal on a desktop, the demo opens the report in the browser. With --live the boats sail
in real time, each with its own flotillad process, and a page in the browser shows them and the
plan. After a live run from a terminal, the page replays it.

Further options go to `flotilla run`, or with --live to `flotilla live`.
"""

import argparse
import os
import signal
import subprocess
import sys
import webbrowser
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

EXAMPLES = ("flotilla demo", "flotilla demo --live", "flotilla demo --law product")
_DESKTOPS = ("DISPLAY", "WAYLAND_DISPLAY", "BROWSER")


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "--live", action="store_true", help="sail in real time, shown in the browser"
    )


def main(options: argparse.Namespace, given: Sequence[str]) -> int:
    """Sail the demo."""
    from sil.cli.main import main as flotilla

    others = [text for text in given[1:] if text != "--live"]

    if not options.live:
        status = flotilla(["run", "lead", "--out", "out/demo", *others])
        if status == 0:
            _show(others)
        return status
    from sil.live.live_world import IS_CLONE, build

    if IS_CLONE:
        print("building flotillad", flush=True)
    build(print)
    view = subprocess.Popen([sys.executable, "-m", "flotilla_usv", "view", "mcast:"])
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


def _show(others: Sequence[str]) -> None:
    """Open the report in the browser, if the command runs in a terminal on a desktop."""
    desktop = sys.platform in ("darwin", "win32") or any(map(os.environ.get, _DESKTOPS))
    if not (desktop and sys.stdin.isatty()):
        return
    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--out", type=Path, default=Path("out/demo"))
    out: Path = parser.parse_known_args(others)[0].out
    webbrowser.open((out / "report.html").resolve().as_uri())
