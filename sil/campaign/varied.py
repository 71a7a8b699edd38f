# SPDX-License-Identifier: MIT
"""Expands a `[[vary]]` into single numbers of the document, each with its value in the file."""

import math
import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from typing import Any

import flotilla
import numpy as np

from sil.scenario.agents import parameters_of
from sil.scenario.scenario import Scenario
from sil.scenario.sections import Vary
from sil.scenario.toml_errors import KeyPath

Value = int | float | str

# A campaign draws the seed itself; all runs share the other keys, which make up their shape.
_FIXED = {"name", "base", "duration_s", "seed", "scalar", "rate_hz", "vary", "boat.*.follows"}

_ELEMENT = re.compile("[1-9][0-9]{0,8}")


@dataclass(frozen=True)
class Varied:
    """One number that is drawn: its place, its distribution, and its value in the file."""

    path: KeyPath
    vary: Vary
    own: Any

    @property
    def name(self) -> str:
        """Its dotted key."""
        return ".".join(self.path)

    def draw(self, rng: np.random.Generator) -> Value:
        """Draw the new value of the key."""
        drawn: Value
        if self.vary.choice is not None:
            drawn = self.vary.choice[int(rng.integers(len(self.vary.choice)))]
        elif self.vary.normal is not None:
            drawn = float(rng.normal(*self.vary.normal))
        else:
            assert self.vary.uniform is not None
            drawn = float(rng.uniform(*self.vary.uniform))
        if self.vary.combine == "set":
            return drawn
        # both are numbers: Sampler has checked
        combined: Value = self.own + drawn if self.vary.combine == "add" else self.own * drawn
        return combined


def varied(vary: Vary, nominal: Scenario, complete: dict[str, Any]) -> Iterator[Varied]:
    """The numbers that a `[[vary]]` draws; LookupError if it is invalid.

    `complete`: the complete document of `nominal`.
    """
    _need_numbers(vary)
    path = tuple(vary.key.split("."))
    every = ("boat", "*", *path[2:]) if path[0] == "boat" else path
    if ".".join(every) in _FIXED:
        raise LookupError("it is not varied: a campaign draws seeds, and its runs share a shape")
    if path[0] == "parameters":
        _need_common(path[-1], vary, nominal, complete)
    numbers = [path]
    if path[:2] == ("boat", "*"):
        boats = range(1, len(complete["boat"]) + 1)
        numbers = [("boat", str(boat), *path[2:]) for boat in boats]
    for concrete in numbers:
        own = at(complete, concrete)
        if isinstance(own, list | tuple):
            elements = [((*concrete, str(i)), value) for i, value in enumerate(own, start=1)]
        else:
            elements = [(concrete, own)]
        for element, value in elements:
            if isinstance(value, dict):
                raise LookupError("a table, not a number")
            given = [value, *(vary.choice or ())]
            if vary.combine != "set" and not all(isinstance(x, int | float) for x in given):
                raise LookupError(f'combine = "{vary.combine}" needs numbers')
            yield Varied(element, vary, value)


def _need_numbers(vary: Vary) -> None:
    """LookupError if a `[[vary]]` has no valid distribution."""
    ways = [vary.normal, vary.uniform, vary.choice]
    if sum(way is not None for way in ways) != 1:
        raise LookupError("must have one of normal, uniform, choice")
    if vary.normal and vary.normal[1] < 0.0:
        raise LookupError(f"normal = {list(vary.normal)}: a standard deviation is not negative")
    if vary.uniform and vary.uniform[0] > vary.uniform[1]:
        raise LookupError(f"uniform = {list(vary.uniform)}: the lower number comes first")
    if vary.uniform and not math.isfinite(vary.uniform[1] - vary.uniform[0]):
        raise LookupError(f"uniform = {list(vary.uniform)}: the numbers are too far apart")


def _need_common(name: str, vary: Vary, nominal: Scenario, complete: dict[str, Any]) -> None:
    """LookupError if a firmware parameter is varied for all boats, but boats have their own."""
    remedy = f'vary "boat.*.parameters.{name}"'
    for number, boat in enumerate(nominal.boat, start=1):
        if name in boat.parameters:
            raise LookupError(f"boat {number} has its own: {remedy}")
    aboard = {boat["parameters"].get(name) for boat in complete["boat"]}
    if vary.combine != "set" and len(aboard) > 1:
        raise LookupError(f"each boat has its own: {remedy}")


def complete_document(nominal: Scenario) -> dict[str, Any]:
    """The scenario as a document in which every boat has all of its own keys."""
    aboard = [flotilla.derived(own) for own in parameters_of(nominal, {})]
    document = nominal.model_dump()
    document["leader"]["navigation"] = nominal.leader_unit()._asdict()
    vessels, propellers = nominal.vessels()[1:], nominal.propeller_pairs()
    for i, boat in enumerate(nominal.boat):
        document["boat"][i].update(
            vessel=vessels[i].model_dump(),
            propellers=asdict(propellers[i]),
            navigation=nominal.boat_unit(boat)._asdict(),
            parameters=aboard[i],
        )
    document["parameters"] = aboard[0]
    return document


def at(document: Any, path: KeyPath) -> Any:
    """The value at `path`; LookupError names the missing key."""
    for i, name in enumerate(path):
        if isinstance(document, dict) and name in document:
            document = document[name]
        elif (
            isinstance(document, list | tuple)
            and _ELEMENT.fullmatch(name)
            and int(name) <= len(document)
        ):
            document = document[int(name) - 1]
        else:
            there = f'no "{name}" in "{".".join(path[:i])}"' if i else f'no key "{name}"'
            raise LookupError(there)
    return document


def array_of(path: KeyPath, complete: dict[str, Any]) -> KeyPath:
    """The array that `path` is an element of, or `path` itself."""
    inside = path[:-1]
    return (
        inside if _ELEMENT.fullmatch(path[-1]) and isinstance(at(complete, inside), tuple) else path
    )
