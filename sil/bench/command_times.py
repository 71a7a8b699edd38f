# SPDX-License-Identifier: MIT
"""Measures how long a user waits for a command, and how much of that time is sailing."""

import json
import resource
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from rich.console import Console
from rich.progress import track
from rich.table import Table

_ROUNDS = 5
_RUNS = 100
_COMMANDS: tuple[tuple[str, ...], ...] = (
    ("--help",),
    ("run", "diamond"),
    ("campaign", "paper_monte_carlo", "--runs", str(_RUNS)),
)


def tell(console: Console) -> None:
    """Run each command five times, and print medians."""
    title = f"from the command to its end, medians of {_ROUNDS}"
    table = Table("flotilla", title=title, title_justify="left")
    for column in ("seconds", "of these sailing", "seconds of CPU"):
        table.add_column(column, justify="right")
    rounds = [(words, k) for words in _COMMANDS for k in range(_ROUNDS)]
    found: dict[tuple[str, ...], list[tuple[float, float, float]]] = {}
    for words, _ in track(rounds, console=console, transient=True):
        found.setdefault(words, []).append(_once(words))
    for words, times in found.items():
        medians = [statistics.median(column) for column in zip(*times, strict=True)]
        wall_s, sailing_s, cpu_s = medians
        sailed = f"{sailing_s:.2f}" if sailing_s else "–"
        table.add_row(" ".join(words), f"{wall_s:.2f}", sailed, f"{cpu_s:.2f}")
    console.print(table)


def _once(words: tuple[str, ...]) -> tuple[float, float, float]:
    """Seconds of a command, of its sailing, and of processor time."""
    with tempfile.TemporaryDirectory() as folder:
        out = ["--out", f"{folder}/out"] if len(words) > 1 else []
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        began_s = time.perf_counter()
        command = [sys.executable, "-m", "sil", *words, *out]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)  # noqa: S603
        wall_s = time.perf_counter() - began_s
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        cpu_s = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        return wall_s, _sailing_s(Path(folder) / "out"), cpu_s


def _sailing_s(out: Path) -> float:
    """The command's own figure for its sailing, s; 0 if it sails nothing."""
    for name in ("summary.json", "campaign.json"):
        if (out / name).is_file():
            return float(json.loads((out / name).read_text(encoding="utf-8"))["wall_s"])
    return 0.0
