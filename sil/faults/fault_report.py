# SPDX-License-Identifier: MIT
"""The outcomes of a matrix of faults as a table, as faults.json and as faults.md."""

import json
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from rich.console import JustifyMethod
from rich.table import Table

from sil.common import files
from sil.faults.fault_outcome import Outcome
from sil.faults.soak import Soaked

_COLUMNS = ("fault", "detected after", "state", "thrust after", "recovered after", "pass")


def table(outcomes: Sequence[Outcome]) -> Table:
    """A table for the terminal; failures give the reason."""
    out = Table(title="faults")
    for name in _COLUMNS:
        justify: JustifyMethod = "right" if "after" in name else "left"
        out.add_column(name, justify=justify, no_wrap=name == "fault")
    for one in outcomes:
        *cells, verdict = _cells(one)
        out.add_row(*cells, verdict if one.passed else f"[bold red]{verdict}: {one.why}")
    return out


def soak_table(soaked: Soaked) -> Table:
    """The number of each fault, and the slowest recovery of all boats to FORMATION."""
    out = Table("fault", "times", "slowest recovery, s", title="soak")
    for kind, times in sorted(soaked.faults.items()):
        out.add_row(kind, str(times), f"{soaked.slowest_s.get(kind, float('nan')):.1f}")
    return out


def summary(outcomes: Sequence[Outcome]) -> str:
    """The summary: the last line."""
    passed = sum(one.passed for one in outcomes)
    return f"{passed} passed, {len(outcomes) - passed} failed"


def write(out: Path, outcomes: Sequence[Outcome]) -> None:
    """Write faults.json and faults.md into a folder, which is created."""
    out.mkdir(parents=True, exist_ok=True)
    content = json.dumps([files.plain(asdict(one)) for one in outcomes], indent=2, allow_nan=False)
    files.replace(out / "faults.json", f"{content}\n".encode())
    lines = ["# Faults", "", " | ".join(("", *_COLUMNS, "")).strip(), "|" + "---|" * len(_COLUMNS)]
    for one in outcomes:
        *cells, verdict = _cells(one)
        verdict = verdict if one.passed else f"**{verdict}**: {one.why}"
        lines.append(f"| {' | '.join((*cells, verdict))} |")
    text = "\n".join([*lines, "", summary(outcomes), ""])
    files.replace(out / "faults.md", text.encode())


def _cells(one: Outcome) -> tuple[str, ...]:
    detected, recovered = _seconds(one.detected_s), _seconds(one.recovered_s)
    verdict = "yes" if one.passed else "NO"
    return one.fault, detected, one.state, f"{one.thrust_after_N:.2f} N", recovered, verdict


def _seconds(time_s: float | None) -> str:
    return "–" if time_s is None else f"{time_s:.2f} s"
