# SPDX-License-Identifier: MIT
"""Cost of a fleet in lockstep by its size: speed, memory, stages of a tick."""

import multiprocessing
import os
import statistics
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypedDict

import flotilla
from rich.table import Table

from sil.lockstep.batch import Batch
from sil.lockstep.start import start
from sil.lockstep.trace import Tracer
from sil.scenario import scenario
from sil.scenario.scenario import Scenario
from sil.scenario.virtual_leaders import VirtualLeaders

SIZES = (1, 4, 100, 1000)
ROUNDS = 3
# Boat-seconds per measurement, and the least duration, s.
_BOAT_SECONDS, _LEAST_S = 4000.0, 4.0
_KEEP_S = 1.0

_STAGES = {
    "codec": ("units", "decode", "can", "links"),
    "control": ("tick",),
}


class FleetFigure(TypedDict):
    """Figures of one size, medians of several rounds; `stages_us`: per boat and tick."""

    boats: int
    boat_seconds_per_s: float
    resident_kB: float
    stages_us: dict[str, float]


def tree(boats: int, duration_s: float) -> Scenario:
    """`diamond` with that many boats: boat i follows boat i/2, boat 1 the virtual leader.

    Each level is 4 m behind the one before, boats of the last level 2 m apart; all start in their
    slots.
    """
    levels = boats.bit_length()
    slots = [(0.0, 0.0)]
    fleet = []
    for number in range(1, boats + 1):
        beside_m = 2.0 ** (levels - number.bit_length())
        offset_m = (-4.0, beside_m if number % 2 else -beside_m) if number > 1 else (0.0, 0.0)
        north_m, east_m = slots[number // 2]
        slots.append((north_m + offset_m[0], east_m + offset_m[1]))
        eta = (*slots[number], 0.0)
        fleet.append({"follows": number // 2, "offset_m": offset_m, "eta": eta})
    diamond = scenario.load("diamond").model_dump(exclude_unset=True)
    changed = {"name": f"tree_{boats}", "duration_s": duration_s, "boat": fleet}
    return Scenario.model_validate({**diamond, **changed})


def measure(advance: Callable[[], None]) -> list[FleetFigure]:
    """Sail every size several times, in alternation, each in its own process."""
    rounds: dict[int, list[FleetFigure]] = {size: [] for size in SIZES}
    context = multiprocessing.get_context("spawn")
    for _ in range(ROUNDS):
        for size in SIZES:
            with context.Pool(1) as pool:
                rounds[size].append(pool.apply(sail, (size, _duration_s(size))))
            advance()
    return [_median(figures) for figures in rounds.values()]


def _duration_s(boats: int) -> float:
    return max(_LEAST_S, _BOAT_SECONDS / boats)


def _median(rounds: list[FleetFigure]) -> FleetFigure:
    stages = rounds[0]["stages_us"]
    return {
        "boats": rounds[0]["boats"],
        "boat_seconds_per_s": statistics.median(one["boat_seconds_per_s"] for one in rounds),
        "resident_kB": statistics.median(one["resident_kB"] for one in rounds),
        "stages_us": {s: statistics.median(one["stages_us"][s] for one in rounds) for s in stages},
    }


def sail(boats: int, duration_s: float) -> FleetFigure:
    """Sail a fleet of that size twice: first unprofiled, then with every stage timed."""
    # Exclude compilation and its memory from the measurement.
    for _ in _steps(_batch(tree(1, 0.1), profile=False)):
        pass
    before_kB = resident_now_kB()
    batch = _batch(tree(boats, duration_s), profile=False)
    wall_s = sum(fleet_s + rest_s for fleet_s, rest_s in _steps(batch))
    resident_kB = resident_now_kB() - before_kB
    figure: FleetFigure = {
        "boats": boats,
        "boat_seconds_per_s": boats * duration_s / wall_s,
        "resident_kB": resident_kB,
        "stages_us": {},
    }
    profiled = _batch(tree(boats, duration_s), profile=True)
    steps = list(_steps(profiled))
    seconds: dict[str, float] = profiled.fleet.profile()
    us = 1e6 / (len(steps) * boats)
    figure["stages_us"] = {"plant": us * sum(rest_s for _, rest_s in steps)}
    for stage, parts in _STAGES.items():
        figure["stages_us"][stage] = us * sum(seconds[part] for part in parts)
    return figure


def _batch(one: Scenario, *, profile: bool) -> Batch:
    return Batch([one], {}, profile=profile)


def _steps(batch: Batch) -> Iterator[tuple[float, float]]:
    """Sail to the end; return each tick's seconds for fleet and wires, and for the plant."""
    ready_us = start(batch)[0]
    if not isinstance(ready_us, int):
        raise ready_us
    batch.fleet.profile()
    tracer = Tracer(batch.scenarios, batch.bodies, batch.slots, _KEEP_S)
    leaders = VirtualLeaders(batch.scenarios)
    for k in range(tracer.ticks):
        began_s = time.perf_counter()
        if k > 0:
            batch.tick(ready_us + k * batch.h_us)
        ticked_s = time.perf_counter()
        leaders.advance(k, batch.bodies, batch.command)
        tracer.note(k, batch.fleet.states)
        yield ticked_s - began_s, time.perf_counter() - ticked_s


def resident_now_kB() -> float:
    """Resident memory of this process, kB."""
    pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    return pages * os.sysconf("SC_PAGESIZE") / 1000.0


def table(figures: list[FleetFigure]) -> Table:
    """The figures for a terminal."""
    title = f"fleets in one spanning tree, one core: medians of {ROUNDS} (flotilla "
    out = Table("boats", title=f"{title}{flotilla.__version__})", title_justify="left")
    for column in ("boat-seconds/s", "µs a boat-tick: plant", "codec", "control", "resident MB"):
        out.add_column(column, justify="right")
    for figure in figures:
        stages = (f"{us:.2f}" for us in figure["stages_us"].values())
        speed = f"{figure['boat_seconds_per_s']:,.0f}"
        out.add_row(f"{figure['boats']:,}", speed, *stages, f"{figure['resident_kB'] / 1000:.1f}")
    return out


def told(figures: list[FleetFigure]) -> str:
    """Cost and memory of the largest fleet compared with the next smaller one, with targets."""
    large, small = figures[-1], figures[-2]
    cost = small["boat_seconds_per_s"] / large["boat_seconds_per_s"]
    more = large["boats"] - small["boats"]
    memory_kB = (large["resident_kB"] - small["resident_kB"]) / more
    return (
        f"a boat-second among {large['boats']:,} boats costs {cost:.2f} × that among "
        f"{small['boats']} (target 1.2); {memory_kB:.1f} kB resident a boat more (target 20)"
    )
