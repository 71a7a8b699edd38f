# SPDX-License-Identifier: MIT
"""Boats among others: strangers that keep course and speed, and fleets that change places.

    python -m tests.loop.encounters [HULL…] [--runs 1000]

A boat in its slot meets a vessel of no formation, which would pass within its guard of it: at the
defaults, heard 2 to 20 times a second, up to 0.3 s late, with noise. Then fleets: boats that begin
in each other's slots, and 20 boats in random places. Prints who came nearer than FS_SEP_M, on which
side strangers were passed, and who did not arrive. Lengths and times grow with the hull's length,
as LAW_R_MAX falls with it; speeds are the same for all.

The side is judged where the rules of the road have one. Crossing, from starboard: the boat does not
cross ahead of the stranger. Bow to bow: they pass port to port. From port: until they are nearest,
the boat does not go to port of its way. Who overtakes, or is overtaken, may pass on either side.
"""

import argparse
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from pymavlink.dialects.v20 import common as mavlink
from rich.console import Console
from rich.progress import track

from sil.lockstep import metrics
from sil.lockstep.batch import Batch
from sil.lockstep.world import Run, all_sailed, sail
from sil.plant.hull import Array
from sil.scenario import presets, scenario
from sil.scenario.scenario import Scenario
from sil.scenario.wiring import ORIGIN
from tests.loop.presets import GUARD, LEADER, SHORTEST_M, length_m
from tests.target.stations import Station, heartbeat

#: Of a boat of SHORTEST_M; in proportion to the length of others: distance to its leader, and
#: between slots, with room to pass: 2.9 times the guard.
SLOT_NORTH_M, SPACING_M = -3.0, 4.5
# Distance from the slot, of a boat of SHORTEST_M. A boat at rest up to 1.5 LAW_XT_DIST abeam of
# its slot stays there.
ARRIVED_M, AT_REST_M = 0.2, 0.75
D11 = LEADER.d11  # kg/s: surge force of the leader over its speed
TOGETHER = 50
STRANGER = 77
FLEET = """[navigation]
rate_hz = 20.0
position_noise_m = 0.02
heading_noise_rad = 0.0087
velocity_noise_mps = 0.02
yaw_rate_noise_radps = 0.0035
[link]
delay_s = 0.1
everyone = true
"""


@dataclass(frozen=True)
class Encounter:
    """A stranger, `there` (north, east) at the release, with velocity `v`; how it is heard.

    `hull`: of the boat that it meets.
    """

    hull: str
    slot_mps: float
    there: Array
    v: Array
    rate_hz: float
    delay_s: float
    seed: int

    def at(self, t_s: Array | float) -> Array:
        return self.there + np.multiply.outer(t_s, self.v)

    @property
    def bearing(self) -> float:
        return math.atan2(self.there[1], self.there[0] - SLOT_NORTH_M * scale(self.hull))

    @property
    def kind(self) -> str:
        """The rule that applies: "ahead", "starboard", "port", or "either"."""
        course, speed = math.atan2(self.v[1], self.v[0]), math.hypot(*self.v)
        sector = math.radians(67.5)
        if abs(self.bearing) > math.pi - sector or (abs(course) < sector and speed < self.slot_mps):
            return "either"
        if abs(course) > math.radians(157.5) and abs(self.bearing) < math.radians(22.5):
            return "ahead"
        return "starboard" if self.bearing > 0.0 else "port"


def scale(hull: str) -> float:
    """A hull's length, in those of a boat at the defaults."""
    return length_m(hull) / SHORTEST_M


def guard_m(hull: str) -> float:
    """FS_SEP_M at its default."""
    return GUARD * length_m(hull)


def drawn(hull: str, number: int) -> Encounter:
    rng = np.random.default_rng([7, number])
    while True:
        slot = rng.uniform(0.3, 1.2)
        speed, course = rng.uniform(0.0, 2.0), rng.uniform(-math.pi, math.pi)
        meet_s, miss_m = scale(hull) * rng.uniform(10.0, 22.0), scale(hull) * rng.uniform(-1.5, 1.5)
        v = speed * np.array([math.cos(course), math.sin(course)])
        relative = v - [slot, 0.0]
        fast = math.hypot(*relative)
        if fast < 0.15:
            continue
        aside = np.array([-relative[1], relative[0]]) / fast
        here = np.array([SLOT_NORTH_M * scale(hull), 0.0])
        there = here + miss_m * aside - relative * meet_s
        if math.hypot(*(there - here)) > 6.0 * scale(hull):
            rate_hz, delay_s = rng.uniform(2, 20), rng.uniform(0.02, 0.3)
            return Encounter(hull, slot, there, v, rate_hz, delay_s, number)


def scenario_of(seed: int, duration_s: float, text: str, folder: Path) -> Scenario:
    path = folder / f"run{seed}.toml"
    head = f"seed = {seed}\nduration_s = {duration_s}\n"
    path.write_text(head + FLEET + text, encoding="utf-8")
    return scenario.load(path)


def leader_at(speed_mps: float) -> str:
    return (
        f"[leader]\nnu = [{speed_mps}, 0.0, 0.0]\n[[leader.input]]\nsurge_N = {D11 * speed_mps}\n"
    )


def boat_at(hull: str, offset: Sequence[float], eta: Sequence[float]) -> str:
    place = f"follows = 0\noffset_m = {list(offset)}\neta = {list(eta)}"
    return f'[[boat]]\nhull = "{hull}"\n{place}\n'


class Strangers:
    """Sends the messages of a batch's strangers at each tick of `sail`; one stranger a run."""

    def __init__(self, met: Sequence[Encounter]) -> None:
        self.met = met
        self.stations = [Station(STRANGER) for _ in met]
        self.rng = [np.random.default_rng([8, each.seed]) for each in met]
        self.next_s = np.zeros(len(met))
        self.begun_us = 0

    def __call__(self, batch: Batch, members: Sequence[int], k: int, t_us: int) -> None:
        if k == 0:
            self.begun_us = t_us
        t_s = 1e-6 * (t_us - self.begun_us)
        for run, member in enumerate(members):
            if t_s < self.next_s[member]:
                continue
            one = self.met[member]
            self.next_s[member] += 1.0 / one.rate_hz
            noise = self.rng[member].normal(0.0, 0.02, 4)
            here, v = one.at(t_s - one.delay_s) + noise[:2], one.v + noise[2:]
            boot_ms = round(1e-3 * t_us - 1e3 * one.delay_s)
            place = mavlink.MAVLink_local_position_ned_message(boot_ms, *here, 0.0, *v, 0.0)
            origin = mavlink.MAVLink_gps_global_origin_message(*ORIGIN, 0)
            beat = heartbeat(mavlink.MAV_TYPE_SURFACE_BOAT)
            wire = self.stations[member].pack(beat, origin, place)
            batch.fleet.hear(batch.agents(run)[0], wire, t_us)


@dataclass(frozen=True)
class Passing:
    """How an encounter ended.

    `least`: how near they came, in guards; `right`: on the side of the rules, None where there is
    none; `left`: the boat was not in FORMATION all the time.
    """

    least: float
    right: bool | None
    arrived: bool
    left: bool


def judged(one: Encounter, run: Run) -> Passing:
    t_s, boat = run.trace["t_s"], run.trace["eta"][:, 1, :2]
    apart = boat - one.at(t_s)
    distance = np.hypot(*apart.T)
    course = math.atan2(one.v[1], one.v[0])
    along = apart @ [math.cos(course), math.sin(course)]
    side = apart @ [-math.sin(course), math.cos(course)]  # to starboard of the stranger's course
    crossed = (side[1:] < 0.0) != (side[:-1] < 0.0)
    near, nearest = distance < 12.0 * scale(one.hull), int(distance.argmin())
    east = boat[: nearest + 1, 1][near[: nearest + 1]]  # on the way to the nearest place
    right = {
        "either": None,
        "ahead": bool(side[nearest] < 0.0),
        "starboard": not np.any(crossed & (along[1:] > 0.0) & near[1:]),
        "port": bool(east.min(initial=0.0) > -0.5 * scale(one.hull)),
    }[one.kind]
    end = float(metrics.distances(run.trace["error"])[-1].max())
    arrived = end < ARRIVED_M * scale(one.hull)
    left = any(state != "FORMATION" for state in run.states[0])
    return Passing(float(distance.min()) / guard_m(one.hull), right, arrived, left)


def encounters(hull: str, numbers: Sequence[int], duration_s: float = 90.0) -> list[Passing]:
    """Each encounter's end; `duration_s` for a boat of SHORTEST_M."""
    found: list[Passing] = []
    north = SLOT_NORTH_M * scale(hull)
    slot = boat_at(hull, [north, 0.0], [north, 0.0, 0.0])
    last_s = round(duration_s * scale(hull), 1)
    with TemporaryDirectory() as folder:
        for begin in track(range(0, len(numbers), TOGETHER), hull, transient=True):
            met = [drawn(hull, number) for number in numbers[begin : begin + TOGETHER]]
            scenarios = [
                scenario_of(one.seed, last_s, leader_at(one.slot_mps) + slot, Path(folder))
                for one in met
            ]
            runs = all_sailed(sail(scenarios, {}, watch=Strangers(met)))
            found += map(judged, met, runs)
    return found


@dataclass(frozen=True)
class Crowd:
    """Fleets of a hull on a grid of slots; boats begin in each other's slots, or scattered."""

    boats: int
    speed_mps: float
    swapped: bool


CROWDS = (Crowd(4, 0.5, True), Crowd(9, 0.0, True), Crowd(12, 0.5, True), Crowd(20, 0.5, False))


def crowd(hull: str, number: int, one: Crowd, folder: Path) -> Scenario:
    """Fleet `number` of a crowd."""
    rng = np.random.default_rng([9, number])
    wide = math.ceil(math.sqrt(one.boats))
    slots = [(-SPACING_M * (i // wide) - 3.0, SPACING_M * (i % wide)) for i in range(one.boats)]
    if one.swapped:
        begin = [(*slots[i], 0.0) for i in rng.permutation(one.boats)]
    else:
        begin = []
        while len(begin) < one.boats:
            side = 2.1 * SPACING_M * wide / 2.0
            here = (*rng.uniform(-side / 1.4, side / 1.4, 2), rng.uniform(-math.pi, math.pi))
            if all(math.hypot(here[0] - x, here[1] - y) > 2.5 for x, y, _ in begin):
                begin.append(here)
    grown = [scale(hull), scale(hull)]
    text = leader_at(one.speed_mps) + "".join(
        boat_at(hull, slot, eta)
        for slot, eta in zip(
            np.round(np.multiply(slots, grown), 3).tolist(),
            np.round(np.multiply(begin, [*grown, 1.0]), 3).tolist(),
            strict=True,
        )
    )
    return scenario_of(number, round(150.0 * scale(hull), 1), text, folder)


def crowds(hull: str, numbers: Sequence[int], one: Crowd) -> Array:
    """Least distance, in guards, and worst last error, in hull lengths over SHORTEST_M, of each."""
    found = []
    with TemporaryDirectory() as folder:
        for n in track(numbers, f"{hull}, {one.boats} boats", transient=True):
            (run,) = all_sailed(sail([crowd(hull, n, one, Path(folder))], {}, keep_s=0.05))
            least = (metrics.min_separation_m(run.trace["eta"]) or 0.0) / guard_m(hull)
            off = float(metrics.distances(run.trace["error"])[-1].max()) / scale(hull)
            found.append((least, off))
    return np.array(found)


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("hull", nargs="*", default=presets.names())
    parser.add_argument("--runs", type=int, default=1000, metavar="N", help="strangers of a hull")
    given = parser.parse_args(arguments)
    for hull in given.hull:
        print_strangers(hull, encounters(hull, range(given.runs)))
        for one in CROWDS:
            print_crowds(hull, one, crowds(hull, range(max(given.runs // 50, 2)), one))
    return 0


def print_strangers(hull: str, passed: Sequence[Passing]) -> None:
    least = [each.least for each in passed]
    sides = [each.right for each in passed if each.right is not None]
    Console().print(
        f"{hull}, {len(passed)} strangers: {sum(each < 1.0 for each in least)} nearer than the "
        f"guard, the nearest {min(least):.2f} of it; on the side of the rules {sum(sides)} of "
        f"{len(sides)}; {sum(not each.arrived for each in passed)} boats not back in their slots, "
        f"{sum(each.left for each in passed)} left FORMATION"
    )


def print_crowds(hull: str, one: Crowd, found: Array) -> None:
    off = found[:, 1] > (ARRIVED_M if one.speed_mps > 0.0 else AT_REST_M)
    Console().print(
        f"{hull}, {one.boats} boats {'in swapped slots' if one.swapped else 'anywhere'}, "
        f"{one.speed_mps} m/s, {len(found)} runs: {np.sum(found[:, 0] < 1.0)} nearer than the "
        f"guard, the nearest {found[:, 0].min():.2f} of it; not arrived in {np.sum(off)}"
    )


if __name__ == "__main__":
    sys.exit(main())
