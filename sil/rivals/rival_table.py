# SPDX-License-Identifier: MIT
"""The table of rivals: printed, and written into the page of measurements."""

import math
from collections.abc import Callable, Mapping, Sequence

from sil import ROOT
from sil.rivals.judge import Figures
from sil.rivals.rivals import OURS, RIVALS, sail
from sil.rivals.routes import ROUTES, WEATHERS

PAGE = ROOT / "sil" / "docs" / "MEASUREMENTS.md"
BEGIN, END = "<!-- rivals: made by flotilla rivals -->\n", "<!-- end -->"
HEAD = ("route, weather", *(name for name in (OURS, *RIVALS)))
#: Names of the weathers in the page: "still" is calm, "sea" is wind.
NAMES = {"still": "calm", "sea": "wind"}

Told = Mapping[str, Mapping[str, Figures]]  # by rival, by route


def sailed(
    weather: str, rivals: Sequence[str], say: Callable[[str], None] = lambda _: None
) -> dict[str, dict[str, Figures]]:
    """Sail all routes in one weather; results by rival. `say` is called with each rival's name."""
    told = {}
    for name in rivals:
        say(f"{name}, {NAMES[weather]}")
        told[name] = sail(name, list(ROUTES), weather)
    return told


def cell(one: Figures) -> str:
    """Mean / worst distance, m; share of the planned speed, %; followers' RMS distance, m."""
    if not one.speed:
        return f"{one.mean_m:.2f} / {one.worst_m:.2f}; lost"
    behind = "" if math.isnan(one.followers_m) else f"; {one.followers_m:.2f}"
    return f"{one.mean_m:.2f} / {one.worst_m:.2f}; {100 * one.speed:.0f} %{behind}"


def rows(weather: str, told: Told) -> list[list[str]]:
    """The table's rows for a weather."""
    return [
        [f"rivals: {route}, {NAMES[weather]}", *(cell(routes[route]) for routes in told.values())]
        for route in ROUTES
    ]


def for_page(lines: Sequence[Sequence[str]], rivals: Sequence[str]) -> str:
    """The table in Markdown."""
    head = ["mean / worst distance from the plan (m); speed; followers (m)", *rivals]
    rule = ["---"] * len(head)
    return "\n".join("| " + " | ".join(line) + " |" for line in (head, rule, *lines)) + "\n"


def write(table: str) -> None:
    """Replace the page's table; ValueError if the page has no place for it."""
    text = PAGE.read_text(encoding="utf-8")
    before, found, rest = text.partition(BEGIN)
    _, ended, behind = rest.partition(END)
    if not (found and ended):
        raise ValueError(f"{PAGE}: no place for the table of rivals")
    PAGE.write_text(f"{before}{BEGIN}{table}{END}{behind}", encoding="utf-8")


def make(rivals: Sequence[str], say: Callable[[str], None]) -> str:
    """Sail all rivals in both weathers; takes about ten minutes."""
    lines: list[list[str]] = []
    for weather in WEATHERS:
        lines += rows(weather, sailed(weather, rivals, say))
    return for_page(lines, rivals)
