# SPDX-License-Identifier: MIT
"""Shows a fleet on a page in the browser, live or recorded. It only listens.

SOURCE is a live fleet: mcast:[GROUP:PORT[:ADDRESS]], udpin:HOST:PORT, tcp:HOST:PORT,
/dev/TTY[:BAUD]. Or it is a recording: a tlog; a boat's folder of tlogs, one for each link; the
folder of a run; or the folder of a campaign, whose worst run is shown.
"""

import argparse
from collections.abc import Sequence
from contextlib import suppress
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from sil.view.live_source import Live

EXAMPLES = (
    "flotilla view mcast:                  # a live run with --mavlink mcast:, or real boats",
    "flotilla view /dev/ttyUSB0:57600      # a telemetry radio",
    "flotilla view out/diamond             # a run",
    "flotilla view out/diamond_live/boat1/log      # what a boat sent and received",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("source", metavar="SOURCE", help="as above")
    parser.add_argument(
        "--bind",
        default="127.0.0.1:8321",
        metavar="HOST:PORT",
        help="address of the page (127.0.0.1:8321 or the next free port; 0: any port); with "
        "0.0.0.0:8321 everybody who can reach this machine sees it",
    )
    parser.add_argument(
        "--length",
        type=_metres,
        metavar="M",
        help="length of the boats, m (the scenario's, or 1 m)",
    )
    parser.add_argument(
        "--chart",
        type=Path,
        metavar="FILE",
        help="chart to draw under the boats: coastlines as GeoJSON, or raster MBTiles",
    )


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Serve the page until interrupted."""
    from sil.view.chart import Chart
    from sil.view.page import PageError
    from sil.view.serve import serve
    from sil.wire.mavlink_mcast import host_and_port

    bind = host_and_port(options.bind, least=0)
    try:
        chart = None if options.chart is None else Chart(options.chart)
        serve(source_of(options.source, options.length), bind, chart)
    except KeyboardInterrupt:
        pass  # Ctrl-C ends the view
    except PageError as error:
        raise ValueError(str(error)) from None
    return 0


def source_of(text: str, length_m: float | None) -> "Live | dict[str, Any]":
    """Open a live source, or read a recorded one; ValueError or OSError if that fails."""
    from sil.lockstep.recording import MAGIC
    from sil.view.history import LENGTH_M
    from sil.view.live_source import Live
    from sil.view.recorded import history_of_run
    from sil.view.tlog_history import history_of_tlog

    path = Path(text)
    if (path / "campaign.json").is_file():
        return _worst_of(path, length_m)
    if any(path.glob("*.tlog")):
        return history_of_tlog(path, length_m or LENGTH_M)
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
    from sil.campaign import worst

    history = worst.read(folder)
    if history is None:
        raise ValueError(
            f"{folder}: the campaign has no {worst.NAME}, so there is no run to play back"
        )
    if length_m is not None:
        for vessel in history["vessels"]:
            vessel["length_m"] = length_m
    return history


def _metres(text: str) -> float:
    """Parse a length in metres; raise an argparse error if it is not a length."""
    with suppress(ValueError):
        if 0.0 < float(text) < inf:
            return float(text)
    raise argparse.ArgumentTypeError(f"{text} is not a length in metres")
