# SPDX-License-Identifier: MIT
"""One thing that was looked at: is it in order, and if not, what helps."""

from dataclasses import dataclass
from enum import StrEnum


class Level(StrEnum):
    """How bad it is; DOUBT does not keep a boat from sailing."""

    OK = "ok"
    DOUBT = "doubt"
    BAD = "bad"


@dataclass(frozen=True)
class Finding:
    """`where`: a file, device, bus or address; `remedy`: empty where nothing is to be done."""

    level: Level
    where: str
    what: str
    remedy: str = ""


def ok(where: str, what: str) -> Finding:
    """In order."""
    return Finding(Level.OK, where, what)


def doubt(where: str, what: str, remedy: str) -> Finding:
    """The boat sails, but perhaps not as it should."""
    return Finding(Level.DOUBT, where, what, remedy)


def bad(where: str, what: str, remedy: str) -> Finding:
    """The boat does not sail with this."""
    return Finding(Level.BAD, where, what, remedy)
