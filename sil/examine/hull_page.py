# SPDX-License-Identifier: MIT
"""sil/docs/HULLS.md: every number of the hulls in sil/hulls with its source; their .param files."""

import tomllib
from collections.abc import Iterator

import flotilla

from sil import ROOT
from sil.examine.scenario_page import meanings
from sil.scenario import hull_files, presets

PAGE = ROOT / "sil" / "docs" / "HULLS.md"
_TABLES = ("cruise", "vessel", "propellers")


def files() -> dict[str, str]:
    """The parameter files of all hulls, by their names."""
    return {
        f"{name}.{suffix}": text
        for name in presets.names()
        for suffix, text in hull_files.texts(name).items()
    }


def firmware_table() -> str:
    """The firmware's parameters, a column for each hull, with the gains that it derives."""
    columns = {}
    for name in presets.names():
        own = presets.firmware(presets.load(name))
        gains = flotilla.derived(own)
        columns[name] = own | {gain: float(f"{gains[gain]:.4g}") for gain in presets.DERIVED}
    rows = list(dict.fromkeys(own for column in columns.values() for own in column))
    lines = [f"| | {' | '.join(columns)} |", "|---|" + "--:|" * len(columns)]
    for row in rows:
        cells = (f"{column[row]:.9g}" if row in column else "–" for column in columns.values())
        lines.append(f"| `{row}` | {' | '.join(cells)} |")
    return "\n".join(lines)


def source_tables() -> str:
    """A heading, sources and a table for each hull."""
    return "\n\n".join(_of(name) for name in presets.names())


def _of(name: str) -> str:
    text = presets.path_of(name).read_text(encoding="utf-8")
    document, said = tomllib.loads(text), meanings(text)
    lines = [f"### [`{name}`](../hulls/{name}.toml)", "", hull_files.about(name), ""]
    lines += [f"- {tag}: {source}" for tag, source in document["sources"].items()]
    lines += ["", "| key | value | source |", "|---|--:|---|"]
    lines += [
        f"| `{key}` | {value:g} | {said[table, key]} |" for table, key, value in _numbers(document)
    ]
    return "\n".join(lines)


def _numbers(document: dict[str, dict[str, float]]) -> Iterator[tuple[str, str, float]]:
    for table in _TABLES:
        for key, value in document[table].items():
            yield table, key, value
