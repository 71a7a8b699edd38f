# SPDX-License-Identifier: MIT
"""TOML with the line of each key, so that errors name file, line, key and remedy."""

import difflib
import json
import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Self, get_args

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

KeyPath = tuple[str, ...]
"""Keys from the root of the document; elements of arrays are counted from "1"."""

_HEADER = re.compile(r"\s*(\[\[?)\s*([\w.\s\"'-]+?)\s*\]\]?\s*(?:#.*)?$")
_KEY = re.compile(r"\s*([\w.\s\"'-]+?)\s*=")
_WORD = re.compile(r"[A-Za-z_][\w-]*", re.ASCII)
_POSITION = re.compile(r" \(at (?:line (\d+), column \d+|end of document)\)$")

# replacements for messages of pydantic that an author of TOML would not understand
_WORDS = {
    "model_type": "must be a table",
    "dict_type": "must be a table",
    "tuple_type": "must be an array",
}
# keys of the radio, which all boats share, but which authors look for in a boat's own table
_OF_THE_RADIO = {"link", "radio", "loss", "delay_s"}
_ONE_RADIO = 'for one boat, use a [[fault]] of kind "radio_loss" or "radio_late"'


class ScenarioError(ValueError):
    """An invalid scenario; the text is for the file's author."""


@dataclass
class Source:
    """A parsed document, the line of each key, and the overrides applied to it.

    Keys from the file's `base` are located in the base; keys that a campaign draws are located at
    their `[[vary]]`, whose path is in `drawn`.
    """

    file: str
    document: dict[str, Any]
    lines: dict[KeyPath, int]
    overrides: dict[KeyPath, str] = field(default_factory=dict)
    base: Self | None = None
    drawn: dict[KeyPath, KeyPath] = field(default_factory=dict)

    @classmethod
    def read(cls, path: Path) -> Self:
        """Parse a file; ScenarioError if it cannot be read or is not TOML."""
        file = _shown(path)
        try:
            # Some editors write a byte order mark first.
            text = path.read_text(encoding="utf-8-sig")
        except OSError as error:
            raise ScenarioError(f"{file}: {error.strerror}") from None
        except UnicodeDecodeError:
            raise ScenarioError(f"{file}: not UTF-8, which TOML requires") from None
        try:
            return cls(file, tomllib.loads(text), locate(text))
        except tomllib.TOMLDecodeError as error:
            raise ScenarioError(_syntax_error(file, text, str(error))) from None

    def lay_over(self, base: Self) -> None:
        """Apply the document's keys to `base`, whose array elements are addressed by number.

        ScenarioError if `base` has no place for a key.
        """
        for path, value in leaves(self.document):
            try:
                lay(base.document, path, value)
            except LookupError as error:
                raise self.error(path, f'no key "{".".join(path)}": {error.args[0]}') from None
        self.document, self.base = base.document, base

    def override(self, text: str) -> None:
        """Apply `KEY=VALUE`; ScenarioError if the document has no place for it.

        The value is TOML; a bare word that is not TOML is a string: `scalar=q16`.
        """
        key, _, value = text.partition("=")
        path = tuple(key.strip().split("."))
        try:
            parsed = tomllib.loads(f"value = {value}")
        except tomllib.TOMLDecodeError:
            word = value.strip()
            parsed = {"value": word} if _WORD.fullmatch(word) else {}
        if not all(path) or parsed.keys() != {"value"}:
            wanted = """KEY=VALUE, where the value is a word or TOML: 0.1, [0, 0], '"a text"'"""
            raise ScenarioError(f'override "{text}": must be {wanted}')
        try:
            lay(self.document, path, parsed["value"])
        except LookupError as error:
            raise ScenarioError(f'override "{text}": no key "{key}": {error.args[0]}') from None
        self.overrides[path] = text

    def error(self, path: KeyPath, problem: str) -> ScenarioError:
        """The error `problem` of the key at `path`, with file and line."""
        return ScenarioError(f"{self._place(path)}: {problem}")

    def errors(self, error: ValidationError, model: type[BaseModel]) -> ScenarioError:
        """All validation errors of the document read as `model`, one per line."""
        texts = []
        for detail in error.errors(include_url=False):
            loc = [part for part in detail["loc"] if part != "[key]"]
            path = tuple(str(part + 1) if isinstance(part, int) else part for part in loc)
            texts.append(f"{self._place(path)}: {_problem(detail, path, model)}")
        return ScenarioError("\n".join(dict.fromkeys(texts)))

    def _place(self, path: KeyPath) -> str:
        path = self.drawn.get(path, path)
        for key, text in reversed(self.overrides.items()):
            if key[: len(path)] == path or path[: len(key)] == key:
                return f'override "{text}"'
        shown: Source = self
        while path and path not in shown.lines:
            if self.base is not None and path in self.base.lines:
                shown = self.base
            else:
                path = path[:-1]
        return f"{shown.file}:{shown.lines.get(path, 1)}"


def locate(text: str) -> dict[KeyPath, int]:
    """Line, from 1, of every table and key of a TOML text; omits keys of inline tables."""
    lines: dict[KeyPath, int] = {}
    elements: dict[KeyPath, int] = {}
    table: KeyPath = ()
    for number, line in enumerate(text.split("\n"), start=1):
        if header := _HEADER.match(line):
            table = ()
            *parents, last = _names(header[2])
            for name in parents:
                table += (name,)
                if table in elements:
                    table += (str(elements[table]),)
            table += (last,)
            lines.setdefault(table, number)
            if header[1] == "[[":
                elements[table] = elements.get(table, 0) + 1
            if table in elements:
                table += (str(elements[table]),)
            lines.setdefault(table, number)
        elif key := _KEY.match(line):
            lines.setdefault(table + _names(key[1]), number)
    return lines


def _names(dotted: str) -> KeyPath:
    return tuple(name.strip(" \t\"'") for name in dotted.split("."))


def leaves(table: dict[str, Any], at: KeyPath = ()) -> Iterator[tuple[KeyPath, Any]]:
    """Paths and values of all keys of `table`, nested ones too, whose value is not a table."""
    for key, value in table.items():
        if isinstance(value, dict) and value:
            yield from leaves(value, (*at, key))
        else:
            yield (*at, key), value


def lay(place: Any, path: KeyPath, value: Any) -> None:
    """Set the key `path` of `place`, creating tables; LookupError if it has no place there."""
    head: Any = path[0]
    if isinstance(place, list):
        if not head.isdecimal() or not 1 <= int(head) <= len(place):
            raise LookupError(f'"{head}" must be a number from 1 to {len(place)}')
        head = int(head) - 1
    elif not isinstance(place, dict):
        raise LookupError(f"{json.dumps(place, default=str)} is not a table")
    if len(path) == 1:
        place[head] = value
        return
    lay(place.setdefault(head, {}) if isinstance(place, dict) else place[head], path[1:], value)


def _problem(detail: ErrorDetails, path: KeyPath, model: type[BaseModel]) -> str:
    kind, loc, key = detail["type"], detail["loc"], ".".join(path)
    if kind == "extra_forbidden":
        allowed = list(_annotation(model, loc[:-1]).model_fields)
        close = difflib.get_close_matches(path[-1], allowed, n=1)
        hint = f'did you mean "{close[0]}"?' if close else f"allowed: {', '.join(allowed)}"
        if path[0] == "boat" and path[-1] in _OF_THE_RADIO:
            hint = _ONE_RADIO
        return f'unknown key "{key}" ({hint})'
    if kind == "string_pattern_mismatch":
        return f'"{key}": a parameter\'s name has up to 16 characters: A-Z, 0-9 and _'
    given = json.dumps(detail["input"], default=str)
    if kind == "too_long" or (kind == "missing" and isinstance(loc[-1], int)):
        array = loc if kind == "too_long" else loc[:-1]
        key = ".".join(path[: len(array)])
        return f'"{key}" = {given}: must have {len(get_args(_annotation(model, array)))} numbers'
    if kind == "missing":
        return f'missing key "{key}"'
    return f'"{key}" = {given}: {_WORDS.get(kind, detail["msg"].replace("Input should", "must"))}'


def _annotation(model: Any, loc: tuple[int | str, ...]) -> Any:
    for part in loc:
        is_element = isinstance(part, int)
        model = get_args(model)[0] if is_element else model.model_fields[part].annotation
    return model


def _syntax_error(file: str, text: str, words: str) -> str:
    position = _POSITION.search(words)
    last = text.rstrip().count("\n") + 1
    number = int(position[1]) if position and position[1] else last
    line = text.split("\n")[number - 1].strip()
    return f'{file}:{number}: not TOML: {_POSITION.sub("", words)}, in "{line}"'


def _shown(path: Path) -> str:
    resolved = path.resolve()
    return str(resolved.relative_to(Path.cwd()) if resolved.is_relative_to(Path.cwd()) else path)
