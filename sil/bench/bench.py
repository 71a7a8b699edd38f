# SPDX-License-Identifier: MIT
"""Times the firmware and the simulation, and counts the firmware's instructions.

Times are noisy, so they are medians of several runs; instruction counts are exact. Only the
firmware's instructions count: the difference of two runs of different length under callgrind.
"""

import json
import os
import re
import statistics
import subprocess
import tempfile
import time
from pathlib import Path
from typing import Any, TypedDict

from rich.console import Console
from rich.progress import Progress
from rich.table import Table

from sil import ROOT
from sil.bench import bench_fleet
from sil.bench.strangers import BAUD, strangers
from sil.live.free_port import free_port
from sil.live.live_world import LiveWorld
from sil.live.live_world import build as build_flotillad
from sil.live.udp_end import LOOPBACK
from sil.lockstep.recording import Recording
from sil.lockstep.world import World
from sil.results import radio_share
from sil.scenario import scenario

PROGRAM = ROOT / "build" / "release" / "flotilla_bench"
RUNS = 7
PERCENTILES = "p50", "p99", "p99.9", "max"
DIAMOND_S = 60.0
FIRMWARE_S = 20
TICKS_PER_S = 100
BOAT = 2  # has a leader that is a boat, and has a follower
CALM_BOAT = 3  # beside it


class Figure(TypedDict):
    """One line of the result; None: not measured, or no target."""

    what: str
    median_us: float
    instructions: int | None
    target_us: float | None


def _output(command: list[str], stream: str) -> str:
    done = subprocess.run(command, capture_output=True, text=True, check=False)  # noqa: S603
    if done.returncode != 0:
        raise RuntimeError(f"{' '.join(command)}: {done.stderr.strip()}")
    return done.stderr if stream == "stderr" else done.stdout


def _time_us(case: list[str], n: int) -> float:
    command = [str(PROGRAM), case[0], str(n), *case[1:]]
    runs = [int(_output(command, "stdout")) / 1000 / n for _ in range(RUNS)]
    return statistics.median(runs)


def instructions(case: list[str], n: int) -> int:
    """Instructions of the firmware per tick, over `n` ticks of a case of flotilla_bench."""

    def total(ticks: int) -> int:
        valgrind = ["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"]
        command = [*valgrind, str(PROGRAM), case[0], str(ticks), *case[1:]]
        found = re.search(r"Collected : (\d+)", _output(command, "stderr"))
        assert found is not None
        return int(found[1])

    return round((total(2 * n) - total(n)) / n)


def _figure(what: str, case: list[str], n: int, per: int, target_us: float | None) -> Figure:
    return {
        "what": what,
        "median_us": _time_us(case, n) * per,
        "instructions": instructions(case, min(n // 2, 1000)) * per,
        "target_us": target_us,
    }


def _diamond(folder: Path) -> tuple[float, list[str]]:
    """Wall time per second of `diamond`, and the case that replays one of its boats."""
    chosen = scenario.load("diamond", [f"duration_s={DIAMOND_S}"])
    World(scenario.load("diamond", ["duration_s=0.1"]), {}).run(folder / "warm.bin", lambda _: None)
    walls = []
    for _ in range(3):
        world = World(chosen, {})
        began_s = time.perf_counter()
        world.run(folder / "recording.bin", lambda _: None)
        walls.append(time.perf_counter() - began_s)
    boat = Recording(folder / "recording.bin").header["boats"][BOAT - 1]
    parameters = [f"{name}={value!r}" for name, value in boat["parameters"].items()]
    case = ["replay", str(folder / "recording.bin"), str(BOAT), *parameters]
    return statistics.median(walls) / DIAMOND_S, case


def measure(progress: Progress) -> dict[str, Any]:
    """Measure all figures, in the form that --json writes."""
    rounds = bench_fleet.ROUNDS * len(bench_fleet.SIZES)
    task = progress.add_task("measuring", total=6 + rounds)
    figures: list[Figure] = []

    def add(figure: Figure) -> None:
        figures.append(figure)
        progress.advance(task)

    with tempfile.TemporaryDirectory() as folder:
        wall_s, replay = _diamond(Path(folder))
        progress.advance(task)
        states = "own, leader's state and reference decoded, command encoded"
        add(_figure(f"tick: {states}", ["tick"], 20_000, 1, 2.5))
        add(_figure("tick: the same from ODOMETRY", ["tick_odometry"], 20_000, 1, None))
        add(_figure("ODOMETRY decoded", ["odometry"], 20_000, 1, None))
        ticks = FIRMWARE_S * TICKS_PER_S
        add(_figure("boat-second in diamond, firmware", replay, ticks, TICKS_PER_S, None))
        radio = radio_share.measure(Path(folder))
        progress.advance(task)
    fleets = bench_fleet.measure(lambda: progress.advance(task))
    boats = len(scenario.load("diamond").boat)
    figures.append(
        {
            "what": "boat-second in diamond, whole simulation",
            "median_us": wall_s / boats * 1e6,
            "instructions": None,
            "target_us": 1e6 / boats / 100,
        }
    )
    return {
        "figures": figures,
        "diamond_real_time_factor": 1.0 / wall_s,
        "radio": radio,
        "fleets": fleets,
    }


def measure_live(bus: str, seconds: float, folder: Path, progress: Progress) -> dict[str, Any]:
    """Measure boat 2's flotillad in `diamond`: latencies, share of a core, memory."""
    chosen = scenario.load("diamond", [f"duration_s={seconds}"])
    program = build_flotillad(print)
    task = progress.add_task(f"sailing {seconds:g} s on {bus}", total=1.0)
    used: list[float] = []

    def watch(share: float) -> None:
        progress.update(task, completed=share)
        process = world.boats[BOAT - 1].process
        if process is not None and share < 1.0:
            used[:] = [*_process_figures(process.pid)]

    with LiveWorld(chosen, bus, {}) as world:
        began_s = time.perf_counter()
        world.run(program, folder, watch)
        lasted_s = time.perf_counter() - began_s
    stats = json.loads((folder / f"boat{BOAT}" / "stats.json").read_text(encoding="utf-8"))
    return {**stats, "cpu_share": used[0] / lasted_s, "resident_MB": used[1]}


def measure_flooded(bus: str, seconds: float, folder: Path, progress: Progress) -> dict[str, Any]:
    """Sail `diamond` while strangers disturb boat 2; return the statistics of boats 2 and 3."""
    chosen = scenario.load("diamond", [f"duration_s={seconds}"])
    program = build_flotillad(print)
    task = progress.add_task(f"sailing {seconds:g} s on {bus}", total=1.0)
    port = free_port()
    line = folder / "torn"
    with LiveWorld(chosen, bus, {}) as world:
        links = [f"udpin:{LOOPBACK}:{port},signing=off", f"serial:{line}:{BAUD},signing=off"]
        world.boats[BOAT - 1].more_links += links
        with strangers(port, line) as sent:
            began_s, before = time.monotonic(), sent.value
            world.run(program, folder, lambda share: progress.update(task, completed=share))
            per_s = (sent.value - before) / (time.monotonic() - began_s)
    flooded, calm = (
        json.loads((folder / f"boat{boat}" / "stats.json").read_text(encoding="utf-8"))
        for boat in (BOAT, CALM_BOAT)
    )
    return {"flooded": flooded, "calm": calm, "datagrams_per_s": per_s}


def _process_figures(pid: int) -> tuple[float, float]:
    """Seconds of processor time and MB of resident memory of a process."""
    stat = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()
    ticks_per_s = os.sysconf("SC_CLK_TCK")
    pages = int(Path(f"/proc/{pid}/statm").read_text(encoding="ascii").split()[1])
    return (int(stat[11]) + int(stat[12])) / ticks_per_s, pages * os.sysconf("SC_PAGESIZE") / 1e6


def _print_live(live: dict[str, Any], console: Console) -> None:
    table = Table("µs", title="flotillad at 100 Hz, one of four boats", title_justify="left")
    for column in PERCENTILES:
        table.add_column(column, justify="right")
    rows = {
        "wake-up late by": "lateness_us",
        "processing: wake-up → RawCommand sent": "processing_us",
        "own state received → RawCommand sent": "response_us",
    }
    for what, key in rows.items():
        table.add_row(what, *(str(live[key][p]) for p in PERCENTILES))
    console.print(table)
    console.print(
        f"processing p99 {live['processing_us']['p99']} µs (target 100); "
        f"{100 * live['cpu_share']:.1f} % of a core (target 2); "
        f"{live['resident_MB']:.1f} MB resident (target 10); "
        f"{live['overruns']} overruns in {live['ticks']} ticks"
    )


def _print_flooded(found: dict[str, Any], console: Console) -> None:
    flooded, calm = (found[name]["processing_us"] for name in ("flooded", "calm"))
    console.print(
        f"processing p99 {flooded['p99']} µs (target 100), "
        f"{flooded['p99'] / calm['p99']:.1f} × that of boat {CALM_BOAT} beside it (target 2); "
        f"{found['flooded']['overruns']} overruns in {found['flooded']['ticks']} ticks"
    )
    title = f"boat {BOAT} under {found['datagrams_per_s']:,.0f} datagrams per second"
    table = Table("processing: wake-up → RawCommand sent, µs", title=title, title_justify="left")
    for column in PERCENTILES:
        table.add_column(column, justify="right")
    table.add_row(f"boat {CALM_BOAT}, left alone", *(str(calm[p]) for p in PERCENTILES))
    table.add_row(f"boat {BOAT}, disturbed", *(str(flooded[p]) for p in PERCENTILES))
    console.print(table)


def tell(
    json_file: Path | None, console: Console, live: tuple[str, float] | None, *, flood: bool = False
) -> None:
    """Measure, print tables, write the figures as JSON.

    `live`: flotillad's bus and seconds; `flood`: there, with strangers on a boat's links.
    """
    with Progress(console=console) as progress, tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        folder.chmod(0o755)  # flotillad is another user's
        if live is None:
            result = measure(progress)
        elif flood:
            result = measure_flooded(*live, folder, progress)
        else:
            result = measure_live(*live, folder, progress)
    show = _print if live is None else _print_flooded if flood else _print_live
    show(result, console)
    if json_file:
        json_file.write_text(json.dumps(result, indent=2) + "\n", encoding="utf-8")


def _print(result: dict[str, Any], console: Console) -> None:
    table = Table("what", title="Flotilla: time and instructions", title_justify="left")
    for column in ("median (µs)", "target (µs)", "instructions"):
        table.add_column(column, justify="right")
    for figure in result["figures"]:
        target, instructions = figure["target_us"], figure["instructions"]
        table.add_row(
            figure["what"],
            f"{figure['median_us']:.2f}",
            "" if target is None else f"{target:g}",
            "" if instructions is None else f"{instructions:,}",
        )
    console.print(table)
    console.print(f"diamond: {result['diamond_real_time_factor']:.0f} × real time (target 100)")
    console.print(radio_share.table(result["radio"]))
    console.print(bench_fleet.table(result["fleets"]))
    console.print(bench_fleet.told(result["fleets"]))
