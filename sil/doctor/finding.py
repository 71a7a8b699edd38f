# SPDX-License-Identifier: MIT
"""A finding: something examined, whether it is in order, and the remedy if not."""

from dataclasses import dataclass
from enum import StrEnum


class Level(StrEnum):
    """The severity; DOUBT does not keep a boat from sailing."""

    OK = "ok"
    DOUBT = "doubt"
    BAD = "bad"


@dataclass(frozen=True)
class Finding:
    """A finding. `where`: a file, device, bus or address; `remedy`: empty if none is needed."""

    level: Level
    where: str
    what: str
    remedy: str = ""


def ok(where: str, what: str) -> Finding:
    """A finding that is in order."""
    return Finding(Level.OK, where, what)


def doubt(where: str, what: str, remedy: str) -> Finding:
    """A finding with which the boat sails, but perhaps not as it should."""
    return Finding(Level.DOUBT, where, what, remedy)


def bad(where: str, what: str, remedy: str) -> Finding:
    """A finding with which the boat does not sail."""
    return Finding(Level.BAD, where, what, remedy)
