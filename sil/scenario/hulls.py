# SPDX-License-Identifier: MIT
"""`hull = "otter"`: selects a scenario's or a boat's hull by its name in `sil/hulls`."""

from collections.abc import Mapping
from typing import Any

from sil.scenario import law, presets
from sil.scenario.toml_errors import ScenarioError, Source

_TABLES = ("vessel", "propellers")


def is_hull(key: str) -> bool:
    """Whether an override's dotted key names a hull: `hull`, `boat.2.hull`."""
    return key.strip().split(".")[-1] == "hull"


def clear_base(own: Mapping[str, Any], base: dict[str, Any]) -> None:
    """Remove from a base the tables and parameters that the hull of the derived file replaces.

    Thus only keys of the file that names the hull can change that hull. `expand` reports an unknown
    name, because it knows the line.
    """
    pairs = [(own, base)]
    boats, theirs = own.get("boat"), base.get("boat")
    if isinstance(boats, dict) and isinstance(theirs, list):
        pairs += [(boats.get(str(i), {}), boat) for i, boat in enumerate(theirs, start=1)]
    for over, under in pairs:
        if isinstance(over, dict) and presets.is_known(over.get("hull")):
            _clear(under, over["hull"])


def override(source: Source, text: str) -> None:
    """Apply an override that names a hull: it replaces the file's hull and changes to it."""
    key, _, value = text.partition("=")
    # The shell removes quotes, so the path of a hull's file needs none.
    bare = value.strip().endswith(".toml")
    source.override(f'{key}="{value.strip()}"' if bare else text)
    table, name = (
        _table_of(source.document, key.strip().split(".")[:-1]),
        value.strip().strip("\"'"),
    )
    if isinstance(table, dict) and presets.is_known(name):
        _clear(table, name)


def expand(source: Source) -> None:
    """Complete a document: tables and firmware parameters of the hulls that it names.

    Keys of the document take precedence. With the paper's law, a hull sets only those LAW_*
    parameters that scale with the vessel. ScenarioError for an unknown name.
    """
    document = source.document
    _expand(source, document, ())
    boats = document.get("boat")
    for number, boat in enumerate(boats if isinstance(boats, list) else [], start=1):
        if isinstance(boat, dict):
            _expand(source, boat, ("boat", str(number)))


def _expand(source: Source, table: dict[str, Any], path: tuple[str, ...]) -> None:
    name = table.get("hull")
    if not isinstance(name, str):
        return  # no hull, or one that the scenario's own check refuses
    try:
        hull = presets.load(name)
    except ScenarioError as error:
        raise source.error((*path, "hull"), f'"{".".join((*path, "hull"))}": {error}') from None
    parts = {part: getattr(hull, part).model_dump() for part in _TABLES}
    parts["parameters"] = law.kept(presets.firmware(hull), source.document.get("law", "product"))
    for part, values in parts.items():
        own = table.get(part, {})
        if isinstance(own, dict):
            table[part] = {**values, **own}


def _table_of(document: Any, keys: list[str]) -> Any:
    for key in keys:
        document = document[int(key) - 1] if isinstance(document, list) else document[key]
    return document


def _clear(table: dict[str, Any], name: str) -> None:
    for part in _TABLES:
        table.pop(part, None)
    given = table.get("parameters")
    if isinstance(given, dict):
        for parameter in presets.firmware(presets.load(name)):
            given.pop(parameter, None)
