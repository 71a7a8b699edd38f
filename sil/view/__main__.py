# SPDX-License-Identifier: MIT
"""tools/view: a page that shows a fleet, as it sails now or as it was recorded. It only listens."""

import argparse
import sys
from collections.abc import Sequence
from math import inf
from pathlib import Path
from typing import Any

from sil.recording import MAGIC
from sil.view.chart import Chart
from sil.view.history import LENGTH_M
from sil.view.live import Live
from sil.view.page import PageError
from sil.view.recorded import history_of_run
from sil.view.serve import serve
from sil.view.tlog import history_of_tlog
from sil.wire.mavlink_mcast import LOOPBACK, host_and_port

_SOURCE = """a live fleet: mcast:[GROUP:PORT[:ADDRESS]], udpin:HOST:PORT, tcp:HOST:PORT,
/dev/TTY[:BAUD]; or what was recorded: a tlog, the folder of a run, or that of a campaign, whose
worst run is shown"""


def source_of(text: str, length_m: float | None) -> Live | dict[str, Any]:
    """What there is to be seen; ValueError or OSError where it cannot be."""
    path = Path(text)
    if (path / "campaign.json").is_file():
        return _worst_of(path, length_m)
    if path.is_dir():
        return history_of_run(path, length_m)
    if path.is_file():
        with path.open("rb") as file:
            is_recording = file.read(len(MAGIC)) == MAGIC
        if is_recording:
            return history_of_run(path.parent, length_m)
        return history_of_tlog(path, length_m or LENGTH_M)
    return Live(text, length_m or LENGTH_M)


def _worst_of(folder: Path, length_m: float | None) -> dict[str, Any]:
    # a campaign's tables take a second to import
    from sil.campaign import worst  # noqa: PLC0415

    history = worst.read(folder)
    if history is None:
        raise ValueError(f"{folder}: a campaign without {worst.NAME}, no run to play back")
    if length_m is not None:
        for vessel in history["vessels"]:
            vessel["length_m"] = length_m
    return history


def _metres(text: str) -> float:
    """A length; ValueError."""
    length_m = float(text)
    if not 0.0 < length_m < inf:
        raise ValueError(text)
    return length_m


def main(arguments: Sequence[str]) -> int:
    """Exit status: 0 when interrupted, 2 for a mistake of the caller, in one line."""
    parser = argparse.ArgumentParser(prog="tools/view", description=__doc__)
    parser.add_argument("source", help=_SOURCE)
    parser.add_argument(
        "--bind",
        default=f"{LOOPBACK}:8321",
        metavar="HOST:PORT",
        help="where the page is served (127.0.0.1:8321, else the next free port; 0: any); with "
        "0.0.0.0:8321 who can reach this machine sees it",
    )
    parser.add_argument(
        "--length", type=_metres, metavar="M", help="of boats (a scenario's, or 1 m)"
    )
    parser.add_argument(
        "--chart",
        type=Path,
        metavar="FILE",
        help="drawn under the boats: coastlines as GeoJSON, or raster MBTiles",
    )
    options = parser.parse_args(arguments)
    try:
        bind = host_and_port(options.bind, least=0)
        chart = None if options.chart is None else Chart(options.chart)
        serve(source_of(options.source, options.length), bind, chart)
    except KeyboardInterrupt:
        return 0
    except (ValueError, OSError, PageError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
