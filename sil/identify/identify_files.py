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
from sil.identify.vessel_numbers import Boat, hull_file, hull_of, parameters
from sil.report import run_report
from sil.scenario import hull_files

_PAGE = Template((Path(__file__).parent / "identify.html").read_text(encoding="utf-8"))


def write(found: Identification, boat: Boat, folder: Path) -> list[Path]:
    """Write into the folder, which is made; returns the files.

    No parameter file of swapped propellers: no parameter mends them.
    """
    folder.mkdir(parents=True, exist_ok=True)
    picture = io.BytesIO()
    identify_picture.predictions(found).savefig(picture, format="png")
    contents = {
        "predictions.png": picture.getvalue(),
        "identify.html": page(found, boat, picture.getvalue()).encode(),
        "identify.json": (
            json.dumps(document(found, boat), indent=2, allow_nan=False) + "\n"
        ).encode(),
    }
    if not found.wiring.swapped:
        head = identify_report.sentence(found)
        for suffix, text in hull_files.of_values(parameters(found, boat), [f"# {head}"]).items():
            contents[f"hull.{suffix}"] = text.encode()
        contents["hull.toml"] = hull_file(hull_of(found, boat), head).encode()
    for stale in ("hull.param", "hull.params", "hull.toml"):
        if stale not in contents:
            (folder / stale).unlink(missing_ok=True)
    for name, content in contents.items():
        files.replace(folder / name, content)
    return [folder / name for name in contents]


def page(found: Identification, boat: Boat, picture: bytes) -> str:
    """One HTML page that needs no other file."""
    terminal = Console(record=True, width=110, file=io.StringIO(), force_terminal=True)
    identify_report.tell(found, boat, terminal)
    data = base64.b64encode(picture).decode()
    return _PAGE.substitute(
        style=run_report.STYLE,
        logs=escape(", ".join(log.name for log in found.logs)),
        level="good" if identify_report.holds(found) else "bad",
        verdict=escape(identify_report.sentence(found)),
        picture=f'<img alt="Measured and predicted motion" src="data:image/png;base64,{data}">',
        tables=terminal.export_html(inline_styles=True, code_format="<pre>{code}</pre>"),
    )


def document(found: Identification, boat: Boat) -> dict[str, Any]:
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
                "determined": bool(found.intervals.told[k]),
            }
            for k, term in enumerate(TERMS)
        },
        "held_out": [None if s is None else asdict(s) for s in found.held_out],
        "parameters": parameters(found, boat),
    }
    plain: dict[str, Any] = files.plain(told)
    return plain
