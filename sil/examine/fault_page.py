# SPDX-License-Identifier: MIT
"""The table of sil/docs/FAULTS.md: every kind of fault, from the table in C++."""

from sil import ROOT
from sil.scenario.fault_kinds import KINDS, Kind

_ABSURD = 1e6
PAGE = ROOT / "sil" / "docs" / "FAULTS.md"


def table() -> str:
    """The faults, each as a row of a Markdown table."""
    lines = ["| kind | fails | value | agents | meaning |", "|---|---|---|---|---|"]
    for name, kind in KINDS.items():
        agents = "all" if kind.leaders else "boats"
        cells = (f"`{name}`", kind.owner, _value(kind), agents, kind.meaning)
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def _value(kind: Kind) -> str:
    """Unit and limits, without limits that only guard against absurd numbers."""
    if not kind.unit:
        return "–"
    if kind.greatest < _ABSURD:
        return f"{kind.unit}, {kind.least:g} to {kind.greatest:g}"
    return kind.unit if kind.least == -kind.greatest else f"{kind.unit}, at least {kind.least:g}"
