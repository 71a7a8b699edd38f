# SPDX-License-Identifier: MIT
"""The tables of sil/docs/SCENARIOS.md: the scenarios, and every key of a scenario file.

Names, defaults and ranges come from the models; a key's meaning is its comment in diamond.toml.
"""

import re
from collections.abc import Iterator
from types import UnionType
from typing import Any, Literal, get_args, get_origin

from pydantic.fields import FieldInfo

from sil import ROOT
from sil.scenario.scenario import FOLDER, Scenario, load
from sil.scenario.sections import Section

PAGE = ROOT / "sil" / "docs" / "SCENARIOS.md"
_LINE = re.compile(
    r"(?:# )?(?:\[+(?P<table>[\w.]+)\]+|(?P<key>\w+) = [^#]*?)\s*(?:# (?P<says>.*))?"
)
_CONTINUED = re.compile(r"#?\s+#\s+(?P<says>.*)")
_BOUNDS = {"gt": "> {}", "ge": "≥ {}", "lt": "< {}", "le": "≤ {}"}


def scenario_table() -> str:
    """Every scenario of the project: number of boats, duration and first comment."""
    lines = ["| scenario | boats | seconds | about |", "|---|--:|--:|---|"]
    for path in sorted(FOLDER.glob("*.toml")):
        about = " ".join(_head(path.read_text(encoding="utf-8")))
        chosen = load(path.stem)
        link = f"[`{path.stem}`](../{path.relative_to(PAGE.parent.parent).as_posix()})"
        lines.append(f"| {link} | {len(chosen.boat)} | {chosen.duration_s:g} | {about} |")
    return "\n".join(lines)


def _head(text: str) -> Iterator[str]:
    """The lines of the first paragraph of a file's opening comment."""
    for line in text.splitlines():
        if not line.startswith("# "):
            return
        if not line.startswith("# SPDX"):
            yield line.removeprefix("# ")


def tables() -> str:
    """A heading and a Markdown table for each table of the file."""
    said = meanings((FOLDER / "diamond.toml").read_text(encoding="utf-8"))
    return "\n\n".join(_tables(Scenario, "", "", said))


def meanings(text: str) -> dict[tuple[str, str], str]:
    """The comment after each (table, key) of a scenario file; a table's own has the key ""."""
    said: dict[tuple[str, str], str] = {}
    at = ("", "")
    for line in text.splitlines():
        if found := _LINE.fullmatch(line):
            at = (found["table"], "") if found["table"] else (at[0], found["key"])
            said.setdefault(at, found["says"] or "")
        elif (found := _CONTINUED.fullmatch(line)) and at in said:
            said[at] += " " + found["says"]
    return said


def _tables(
    model: type[Section], name: str, brackets: str, said: dict[tuple[str, str], str]
) -> Iterator[str]:
    lines = [f"### {brackets.format(name) or 'At the top of the file'}", ""]
    if about := said.get((name, "")):
        lines += [f"{about[0].upper()}{about[1:]}.", ""]
    lines += ["| key | default | allowed | meaning |", "|---|---|---|---|"]
    inner: list[str] = []
    for key, field in model.model_fields.items():
        section, many = _section(field)
        path = f"{name}.{key}".lstrip(".")
        if section and not (name and key in Scenario.model_fields):
            inner += _tables(section, path, "`[[{}]]`" if many else "`[{}]`", said)
        elif section:
            lines.append(f"| `{key}` | | | of this one alone: [`[{key}]`](#{key}) |")
        else:
            default = "the file's name" if key == "name" else _default(field)
            meaning = _meaning(name, key, said).replace("|", r"\|")
            cells = (f"`{key}`", default, _allowed(field), meaning)
            lines.append(f"| {' | '.join(cells)} |".replace("|  |", "| |"))
    yield "\n".join(lines)
    yield from inner


def _meaning(name: str, key: str, said: dict[tuple[str, str], str]) -> str:
    """The meaning of a table's key; without a comment of its own, that of its namesake."""
    others = (says for (_, other), says in said.items() if other == key)
    return said.get((name, key)) or said.get((key, "")) or next(filter(None, others), "")


def _section(field: FieldInfo) -> tuple[type[Section] | None, bool]:
    """The model of a table, and whether it is an array of tables; None: a plain key."""
    many = get_origin(field.annotation) is tuple
    optional = get_origin(field.annotation) is UnionType
    inner = get_args(field.annotation)[0] if many or optional else field.annotation
    return (inner, many) if isinstance(inner, type) and issubclass(inner, Section) else (None, many)


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "must be given"
    value: Any = field.get_default(call_default_factory=True)
    if value is None or value == {}:
        return "none"
    if isinstance(value, tuple):
        return f"`[{', '.join(f'{one:g}' for one in value)}]`"
    if isinstance(value, bool):
        return f"`{str(value).lower()}`"
    return f'`"{value}"`' if isinstance(value, str) else f"`{value:g}`"


def _allowed(field: FieldInfo) -> str:
    options = [one for kind in _kinds(field.annotation) for one in get_args(kind)]
    if options:
        return ", ".join(f'`"{one}"`' for one in options)
    metadata = [*field.metadata, *_metadata(field.annotation)]
    bounds = [
        form.format(f"{getattr(one, name):.10g}")
        for one in metadata
        for name, form in _BOUNDS.items()
        if getattr(one, name, None) is not None
    ]
    return ", ".join(bounds)


def _kinds(annotation: Any) -> Iterator[Any]:
    """The Literals in an annotation."""
    if get_origin(annotation) is Literal:
        yield annotation


def _metadata(annotation: Any) -> Iterator[Any]:
    """The metadata of `Annotated` types within a union such as `Positive | None`."""
    for one in get_args(annotation):
        yield from getattr(one, "__metadata__", ())
