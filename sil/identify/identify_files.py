# SPDX-License-Identifier: MIT
"""An identification as files, each whole or not at all: a page, its JSON, parameter files."""

import base64
import io
import json
from dataclasses import asdict
from html import escape
from pathlib import Path
from string import Template
from typing import Any

from rich.console import Console

from sil.common import files
from sil.identify import identify_picture, identify_report
from sil.identify.hull_terms import TERMS
from sil.identify.identification import Identification
from sil.identify.identify_report import Fit
from sil.identify.vessel_numbers import Boat, hull_file, hull_of, parameters
from sil.report import run_report
from sil.scenario import hull_files

_PAGE = Template((Path(__file__).parent / "identify.html").read_text(encoding="utf-8"))


def write_hull(found: Identification, boat: Boat, folder: Path) -> list[Path]:
    """Write the hull's files into the folder, creating it if needed; return their paths.

    There are none if the propellers are swapped, which no parameter corrects.
    """
    contents: dict[str, str] = {}
    if not found.wiring.swapped:
        head = identify_report.sentence(found)
        for suffix, text in hull_files.of_values(parameters(found, boat), [f"# {head}"]).items():
            contents[f"hull.{suffix}"] = text
        contents["hull.toml"] = hull_file(hull_of(found, boat), head)
    for stale in ("hull.param", "hull.params", "hull.toml"):
        if stale not in contents:
            (folder / stale).unlink(missing_ok=True)
    return _written(folder, {name: text.encode() for name, text in contents.items()})


def write(found: Identification, boat: Boat, fit: Fit | None, folder: Path) -> list[Path]:
    """Write page, picture and JSON into the folder, creating it if needed; return their paths."""
    picture = io.BytesIO()
    identify_picture.predictions(found).savefig(picture, format="png")
    told = json.dumps(document(found, boat, fit), indent=2, allow_nan=False) + "\n"
    contents = {
        "predictions.png": picture.getvalue(),
        "identify.html": page(found, boat, fit, picture.getvalue()).encode(),
        "identify.json": told.encode(),
    }
    return _written(folder, contents)


def _written(folder: Path, contents: dict[str, bytes]) -> list[Path]:
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in contents.items():
        files.replace(folder / name, content)
    return [folder / name for name in contents]


def page(found: Identification, boat: Boat, fit: Fit | None, picture: bytes) -> str:
    """One HTML page that needs no other file."""
    terminal = Console(record=True, width=110, file=io.StringIO(), force_terminal=True)
    identify_report.tell(found, boat, fit, terminal)
    data = base64.b64encode(picture).decode()
    return _PAGE.substitute(
        style=run_report.STYLE,
        logs=escape(", ".join(log.name for log in found.logs)),
        level="good" if identify_report.holds(found) else "bad",
        verdict=escape(identify_report.sentence(found)),
        picture=f'<img alt="Measured and predicted motion" src="data:image/png;base64,{data}">',
        tables=terminal.export_html(inline_styles=True, code_format="<pre>{code}</pre>"),
    )


def document(found: Identification, boat: Boat, fit: Fit | None) -> dict[str, Any]:
    """The content of identify.json: SI; terms over the inertia in surge."""
    draws = found.intervals.draws
    told = {
        "scenario": "identify",
        "logs": [log.name for log in found.logs],
        "good": identify_report.holds(found),
        "verdict": identify_report.sentence(found),
        "odd": identify_report.remarks(found),
        "terms": {
            term.name: {
                "value": float(found.fit.values[k]),
                "interval": list(found.intervals.of(draws[:, k])),
                "determined": bool(found.intervals.determined[k]),
            }
            for k, term in enumerate(TERMS)
        },
        "held_out": [None if s is None else asdict(s) for s in found.held_out],
        "parameters": parameters(found, boat),
        "gains": None if fit is None else {"fit": fit[0], "verdict": fit[1]},
    }
    plain: dict[str, Any] = files.plain(told)
    return plain
