# SPDX-License-Identifier: MIT
"""Sails one scenario, in lockstep or live, and leaves its results in a folder."""

import json
import shutil
import time
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from math import hypot
from pathlib import Path

import numpy as np
import rich.progress
from rich.console import Console
from rich.progress import BarColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn

from sil.common import files
from sil.lockstep import metrics
from sil.lockstep.metrics import Summary
from sil.lockstep.world import Progress, Run, World, check
from sil.plant.hull import Array
from sil.report import headline, run_report
from sil.report.drawing import CAN_DRAW, Drawing
from sil.scenario.scenario import Scenario
from sil.view.history import boats_of
from sil.view.recorded import history_of, said_of, without_slots

# Boats stop if their own state is 0.5 s old, the firmware's default.
_LATE_US = 300_000
_TCP_FROM = 5760  # port of boat 1, as in other simulators


def run(
    scenario: Scenario,
    out: Path,
    param_overrides: dict[str, float],
    command: str,
    console: Console,
) -> Summary:
    """Sail `scenario`, show progress and a table, write the results into `out`.

    Writes recording.bin, trace.npz, summary.json, the pictures and report.html, each whole or not
    at all. `command` repeats the run. Raises ValueError for a parameter that the firmware refuses,
    StartError if the boats cannot be put into FORMATION, and PolicyViolationError if one breaks a
    rule of the firmware; the recording then exists.
    """
    world = World(scenario, param_overrides)
    out.mkdir(parents=True, exist_ok=True)
    with Drawing() as drawing:
        began_s = time.perf_counter()
        with _bar(scenario, console) as progress:
            result = world.run(out / "recording.bin", progress)
        wall_s = time.perf_counter() - began_s
        return _finish(scenario, out, result, wall_s, command, console, drawing)


def live(
    scenario: Scenario,
    bus: str,
    out: Path,
    param_overrides: dict[str, float],
    command: str,
    console: Console,
    mavlink: str | None = None,
    gcs: str | None = None,
) -> Summary:
    """Sail `scenario` in real time, with a flotillad for each boat; leave the same results.

    Live runs have no digest. `bus` is the address of boat 1's bus; `mavlink` is the address to
    which all radio traffic is repeated; `gcs` is a ground station that may command the boats.
    Raises as `run`, and OSError or can.CanError if the bus or another address cannot be opened.
    """
    # Only live runs need the bus's libraries.
    from sil.live import live_world  # noqa: PLC0415

    if scenario.fault:
        raise ValueError("faults of a scenario happen in lockstep runs only: tools/faults --live")
    check(scenario, param_overrides)
    with live_world.LiveWorld(scenario, bus, param_overrides, mavlink, gcs, _TCP_FROM) as world:
        program = live_world.build(partial(console.print, markup=False))
        out.mkdir(parents=True, exist_ok=True)
        _remove_earlier(out)
        began_s = time.perf_counter()
        for system, port, wished in world.doors():
            taken = "" if port == wished else f" ({wished} is taken)"
            console.print(f"boat {system} is at tcp:127.0.0.1:{port}{taken}")
        with _bar(scenario, console) as progress:
            tracer = world.run(program, out, progress)
        console.print(f"the simulation was at most {world.late_us / 1000:.1f} ms late")
        if world.late_us > _LATE_US:
            console.print(
                "[bold red]this machine was too slow for real time: the boats' data came too late"
            )
    result = Run(tracer.trace(0), tracer.seconds(0), None)
    wall_s = time.perf_counter() - began_s
    with Drawing() as drawing:
        times_s = world.release_unix_s, 1e-6 * world.late_us
        return _finish(scenario, out, result, wall_s, command, console, drawing, *times_s)


def _remove_earlier(out: Path) -> None:
    """Remove an earlier run's logs, parameters, plans, fences, and files that a live run lacks."""
    for name in ("recording.bin", "run.mcap"):
        (out / name).unlink(missing_ok=True)
    for boat in out.glob("boat[0-9]*"):
        (boat / "flotillad.log").unlink(missing_ok=True)
        for folder in ("log", "state"):
            shutil.rmtree(boat / folder, ignore_errors=True)


@contextmanager
def _bar(scenario: Scenario, console: Console) -> Iterator[Progress]:
    bar = rich.progress.Progress(
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TaskProgressColumn(),
        TimeRemainingColumn(),
        console=console,
    )
    with bar:
        task = bar.add_task(f"{scenario.name}: sailing {scenario.duration_s:g} s", total=1.0)
        yield lambda share: bar.update(task, completed=share)


def _finish(
    scenario: Scenario,
    out: Path,
    result: Run,
    wall_s: float,
    command: str,
    console: Console,
    drawing: Drawing,
    release_unix_s: float | None = None,
    late_s: float | None = None,
) -> Summary:
    trace = result.trace
    afloat = boats_of(scenario)
    limits_N = [boat.limits_N for boat in afloat if boat.limits_N is not None]
    recorded = out / "recording.bin" if result.digest is not None else None
    said = said_of(out, trace, recorded, release_unix_s)
    plan = said.boats[0].plan_end() if said and scenario.leader.boat is not None else None
    end_s = None if plan is None else plan["over_s"]
    drawing.begin(scenario.name, trace, limits_N, scenario.leader.name, end_s)
    # figures of a diverged run are not finite
    with np.errstate(all="ignore"):
        boats = _boats(result, plan)
        separation_m = metrics.min_separation_m(trace["eta"])
    summary: Summary = {
        "scenario": scenario.name,
        "seed": scenario.seed,
        "duration_s": scenario.duration_s,
        "wall_s": wall_s,
        "real_time_factor": scenario.duration_s / wall_s,
        "digest": result.digest,
        "release_unix_s": release_unix_s,
        "late_s": late_s,
        "boats": boats,
        "min_separation_m": separation_m,
        "hull_m": max(boat.length_m for boat in afloat),
    }
    if said is not None:
        for boat, heard in zip(boats, said.boats, strict=False):
            if reasons := heard.reasons():
                boat["said"] = reasons
            if heard.is_closing():
                boat["closing_m"] = hypot(boat["final_error"]["x_m"], boat["final_error"]["y_m"])
    if scenario.leader.voyage_room_m is not None:
        summary["voyage"] = "" if said is None else said.boats[0].voyage_over()
    elif plan is not None:
        summary["plan"] = plan
    replayed = history_of(f"{scenario.name}, seed {scenario.seed}", trace, scenario, said)
    save(out, summary, trace)
    pictures = drawing.pictures()
    if "voyage" in summary:
        replayed = without_slots(replayed)
        pictures.pop("errors", None)
        (out / "errors.png").unlink(missing_ok=True)
    run_report.write(out, summary, trace, command, pictures, replayed)
    _tell(scenario, summary, console)
    console.print(f"results: {out}/report.html", soft_wrap=True, markup=False)
    return summary


def _boats(result: Run, plan: metrics.PlanEnd | None) -> list[metrics.BoatSummary]:
    """The boats' figures until the end of `plan`, which gets those of the wait after it."""
    t_s, error, thrust = (result.trace[name] for name in ("t_s", "error", "thrust"))
    end_s = np.inf if plan is None or plan["over_s"] is None else plan["over_s"]
    sailed = t_s <= end_s
    if plan is not None and not sailed.all():
        plan["waiting_m"] = float(metrics.distances(error[~sailed]).max())
    return metrics.boats(t_s[sailed], error[sailed], thrust[sailed], result.states)


def _tell(scenario: Scenario, summary: Summary, console: Console) -> None:
    plain = partial(console.print, soft_wrap=True, markup=False)
    console.print(headline.of_run(summary).marked, soft_wrap=True)
    console.print(run_report.table(summary))
    for boat in summary["boats"]:
        if "closing_m" in boat:
            console.print(f"[bold yellow]boat {boat['id']} closing, {boat['closing_m']:.1f} m")
        if coasted := boat["states"].get("COAST"):
            console.print(f"[bold yellow]boat {boat['id']} was {coasted:.1f} s in COAST")
        if "said" in boat:
            words = "; ".join(boat["said"])
            plain(f"boat {boat['id']} said: {words}", highlight=False)
    for fault in scenario.fault:
        console.print(fault.sentence(scenario.leader.name), soft_wrap=True, highlight=False)
    digest = (summary["digest"] or "none")[:16]
    console.print(
        f"{scenario.duration_s:g} s sailed in {summary['wall_s']:.1f} s, "
        f"{summary['real_time_factor']:.0f} × real time; digest {digest}"
    )
    if not CAN_DRAW:
        console.print(r"the report has no pictures: pip install 'flotilla-usv\[view]' for them")


def save(out: Path, summary: Summary, trace: Mapping[str, Array]) -> None:
    """Write trace.npz and summary.json into the existing folder `out`.

    Numbers of the summary that are not finite become null.
    """
    # numpy's own savez_compressed takes four times as long for a tenth less.
    with (
        files.whole(out / "trace.npz") as file,
        zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as archive,
    ):
        for name, values in trace.items():
            with archive.open(f"{name}.npy", "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, values)
    content = json.dumps(files.plain(dict(summary)), indent=2, allow_nan=False)
    files.replace(out / "summary.json", f"{content}\n".encode())
