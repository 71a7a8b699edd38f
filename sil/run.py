# SPDX-License-Identifier: MIT
"""Sails one scenario in lockstep and leaves its results in a folder."""

import json
import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeRemainingColumn

from sil import metrics, report
from sil.metrics import Summary
from sil.plant.hull import Array
from sil.scenario import Scenario
from sil.world import World


def run(
    scenario: Scenario,
    out: Path,
    param_overrides: dict[str, float],
    command: str,
    console: Console,
) -> Summary:
    """Sail `scenario`, show progress and a table, write the results into `out`.

    Writes recording.bin, trace.npz, summary.json, the pictures and report.html, each whole or not
    at all. `command` is what a reader types to repeat the run. Raises ValueError for a parameter
    that the firmware refuses, StartError where the boats cannot be put into FORMATION.
    """
    world = World(scenario, param_overrides)
    out.mkdir(parents=True, exist_ok=True)
    bar = Progress(
        TextColumn(f"{scenario.name}: sailing {scenario.duration_s:g} s"),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
        console=console,
    )
    with bar:
        task = bar.add_task("", total=1.0)
        began_s = time.perf_counter()
        result = world.run(out / "recording.bin", lambda share: bar.update(task, completed=share))
        wall_s = time.perf_counter() - began_s
    summary: Summary = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "duration_s": scenario.duration_s,
        "wall_s": wall_s,
        "real_time_factor": scenario.duration_s / wall_s,
        "digest": result.digest,
        "boats": metrics.boats(
            result.trace["t_s"], result.trace["error"], result.trace["thrust"], result.states
        ),
        "min_separation_m": metrics.min_separation_m(result.trace["eta"]),
    }
    write(out, summary, result.trace, command)
    console.print(report.table(summary))
    console.print(
        f"{scenario.duration_s:g} s sailed in {wall_s:.1f} s, "
        f"{summary['real_time_factor']:.0f} × real time; digest {result.digest[:16]}"
    )
    console.print(f"results: {out}/report.html", soft_wrap=True)
    return summary


def write(out: Path, summary: Summary, trace: Mapping[str, Array], command: str) -> None:
    """Write trace.npz, summary.json and the report into the existing folder `out`."""
    part = out / ".trace.part.npz"
    # numpy's stubs take any keyword for its own options
    np.savez_compressed(part, **trace)  # type: ignore[arg-type]
    os.replace(part, out / "trace.npz")
    text = out / ".summary.json.part"
    text.write_text(json.dumps(summary, indent=2) + "\n", encoding="utf-8")
    os.replace(text, out / "summary.json")
    report.write(out, summary, trace, command)


def parameters_of(texts: Sequence[str]) -> dict[str, float]:
    """Parameters from `NAME=VALUE` texts; ValueError says which is not of that form."""
    parameters = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            parameters[name.strip()] = float(value)
        except ValueError:
            raise ValueError(f'--param "{text}": must be NAME=VALUE, VALUE a number') from None
    return parameters
