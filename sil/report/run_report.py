# SPDX-License-Identifier: MIT
"""The report of a run: pictures, a page that contains them, a table for the terminal."""

import base64
import math
from collections.abc import Mapping
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from rich import box
from rich.table import Table
from rich.text import Text

from sil.common import files
from sil.common.colours import colour_of
from sil.lockstep.metrics import BoatSummary, Summary
from sil.plant.hull import Array
from sil.report import headline
from sil.view import history
from sil.view import page as view

COLUMNS = (
    "boat",
    "RMS error (m)",
    "max error (m)",
    "settling time (s)",
    "final error (m)",
    "final heading error (rad)",
    "RMS thrust (N)",
)

_PICTURES = {
    "formation": (
        "Formation",
        "Paths of the boats and of their leader, with the formation at several times",
    ),
    "errors": ("Formation error", "Distance of each boat from its slot over time"),
    "thrust": ("Thrust", "Port and starboard thrust of each boat over time"),
}

_HERE = Path(__file__).parent
STYLE = (_HERE / "report.css").read_text(encoding="utf-8")
_PAGE = Template((_HERE / "report.html").read_text(encoding="utf-8"))


def write(
    directory: Path,
    summary: Summary,
    trace: Mapping[str, Array],
    command: str,
    pictures: Mapping[str, bytes],
    told: Mapping[str, Any] | None = None,
) -> None:
    """Write formation.png, errors.png, thrust.png and report.html into an existing directory.

    `trace`: arrays as in trace.npz. `command`: the shell command that repeats the run. `pictures`:
    as `sil.report.drawing.draw` makes them; a voyage has no errors. `told`: the run's history from
    `sil.view.history`, for the replay; by default the history from the trace alone. Each file
    appears whole or not at all.
    """
    for stem, picture in pictures.items():
        files.replace(directory / f"{stem}.png", picture)
    title = f"{summary['scenario']}, seed {summary['seed']}"
    replay = view.frame_with(told or history.of_trace(trace, title), title)
    files.replace(directory / "report.html", page(summary, pictures, command, replay).encode())


def table(summary: Summary) -> Table:
    """The boats' numbers for the terminal."""
    title = f"{summary['scenario']}, seed {summary['seed']}; RMS and max: of the last third"
    grid = Table(title=Text(title, "table.title"), title_justify="left", box=box.SIMPLE_HEAD)
    for column in COLUMNS:
        grid.add_column(column, justify="right", max_width=10)
    for boat in summary["boats"]:
        grid.add_row(*_cells(boat, slots="voyage" not in summary))
    return grid


def page(summary: Summary, pictures: Mapping[str, bytes], command: str, replay: str = "") -> str:
    """The report as one HTML page that needs no other file.

    `pictures` are PNG by stem, `replay` is HTML.
    """
    separation = summary["min_separation_m"]
    found = headline.of_run(summary)
    return _PAGE.substitute(
        pictures="\n".join(_picture(stem, png) for stem, png in pictures.items()),
        style=STYLE,
        replay=replay,
        scenario=escape(summary["scenario"]),
        seed=summary["seed"],
        duration=f"{summary['duration_s']:g} s",
        speed=f"{summary['real_time_factor']:.1f} × real time",
        level=found.level,
        verdict=escape(found.text),
        separation="one boat" if separation is None else f"{separation:.2f} m",
        digest=summary["digest"] or "none: a live run",
        command=escape(command),
        header="".join(f"<th>{escape(column)}</th>" for column in [*COLUMNS, "states"]),
        rows="".join(_row(boat, slots="voyage" not in summary) for boat in summary["boats"]),
    )


def _picture(stem: str, png: bytes) -> str:
    title, alt = _PICTURES[stem]
    source = f"data:image/png;base64,{base64.b64encode(png).decode()}"
    image = f'<img alt="{alt}"\n     src="{source}">'
    return f'<h2>{title}</h2>\n<div class="wide picture">{image}</div>\n'


def _row(boat: BoatSummary, *, slots: bool) -> str:
    states = ", ".join(
        f"{name} {time:.1f} s" for name, time in boat["states"].items() if time > 0.0
    )
    if "closing_m" in boat:
        states += f"; closing, {boat['closing_m']:.1f} m"
    cells = "".join(f"<td>{escape(cell)}</td>" for cell in _cells(boat, slots=slots))
    cells += f'<td class="states">{escape(states)}</td>'
    return f'<tr style="--boat: {colour_of(boat["id"])}">{cells}</tr>\n'


def _cells(boat: BoatSummary, *, slots: bool) -> list[str]:
    if not slots:
        return [str(boat["id"]), *["–"] * (len(COLUMNS) - 2), f"{boat['thrust_rms_N']:.2f}"]
    settling, final = boat["settling_time_s"], boat["final_error"]
    return [
        str(boat["id"]),
        f"{boat['rms_error_m']:.4f}",
        f"{boat['max_error_m']:.4f}",
        "never" if settling is None else f"{settling:.1f}",
        f"{math.hypot(final['x_m'], final['y_m']):.4f}",
        f"{final['psi_rad']:z.4f}",
        f"{boat['thrust_rms_N']:.2f}",
    ]
