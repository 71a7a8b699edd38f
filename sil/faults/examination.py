# SPDX-License-Identifier: MIT
"""Sails the matrix of faults, or random faults, and prints which limits were kept."""

from pathlib import Path

import rich.progress
from rich.console import Console

from sil.faults import fault_report, live_matrix, matrix, rows
from sil.faults.soak import Soaked, soak
from sil.live.live_world import build


def sail(out: Path, only: str | None, console: Console, *, live: bool) -> int:
    """Sail the rows with `only` in their names, or all; exit status 1 if a limit is missed.

    Writes faults.md and faults.json to `out`. `live`: also the live rows; NoVcanError without vcan.
    """
    chosen = [row for row in rows.read() if only is None or only in row.name]
    if not chosen:
        raise ValueError(f"--only {only}: no fault's name contains that; see matrix.toml")
    with rich.progress.Progress(console=console) as bar:
        task = bar.add_task(f"{len(chosen)} faults", total=1.0)
        done = matrix.sail_all(chosen, lambda share: bar.update(task, completed=share))
        if live:
            build(console.print)
            again = bar.add_task("live faults", total=1.0)
            done += live_matrix.rows(lambda share: bar.update(again, completed=share))
    console.print(fault_report.table(done))
    fault_report.write(out, done)
    console.print(f"results: {out}/faults.md", soft_wrap=True, markup=False)
    print(fault_report.summary(done))
    return int(not all(one.passed for one in done))


def soak_for(hours: float, seed: int, console: Console) -> int:
    """Sail random faults for `hours`; exit status 1 without a fault, or if one lasts."""
    if not hours > 0.0:
        raise ValueError(f"--soak {hours:g}: must be positive")
    bar = rich.progress.Progress(console=console)
    with bar:
        task = bar.add_task(f"{hours:g} h of faults", total=1.0)

        def show(share: float, soaked: Soaked) -> None:
            label = f"{hours:g} h: {soaked.faults.total()} faults, {soaked.resident_MB[-1]:.0f} MB"
            bar.update(task, completed=share, description=label)

        soaked = soak(hours, seed, show)
    console.print(fault_report.soak_table(soaked))
    console.print("resident, MB:", " ".join(f"{size:.1f}" for size in soaked.resident_MB))
    for wrong in soaked.wrong:
        console.print(f"[bold red]{wrong}")
    console.print(f"seed {seed}, digest {soaked.digest}")
    failed = len(soaked.wrong)
    if not soaked.faults.total():
        console.print(f"[bold red]no fault happened in {hours:g} h: soak for longer")
        failed = 1
    print(f"{max(soaked.faults.total() - failed, 0)} passed, {failed} failed")
    return int(failed > 0)
