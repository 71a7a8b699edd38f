# SPDX-License-Identifier: MIT
"""Boats learn their own model while they sail: their findings compared with the truth.

    python -m tests.loop.learning [--only wrong|right] [--seeds N] [--minutes N]

`wrong`: hulls that differ from the boats' parameters in one number: how many boats report that
number, after how many minutes, the error of the last value reported, reports of other numbers,
and the worst RMS distance from the slots in the last third. `right`: fleets with correct
parameters, where every report is false. N seeds (20) of N minutes (10) each.
"""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from pymavlink.dialects.v20 import common as mavlink

from sil.lockstep.batch import Batch
from sil.lockstep.world import Run, sail
from sil.scenario import presets, scenario
from sil.wire.mavlink_frames import frames
from tests.loop.presets import BOATS, WEATHER, alike, worst_rms_m

BALANCE, DRAG, YAW = "LRN_BAL", "LRN_DRAG", "LRN_YAWD"
_WORDS = {"weak": BALANCE, "Drag": DRAG, "Yaw": YAW}
#: 3 m/s of wind with gusts, 0.1 m/s of current; what stands above the water of a boat of 1.3 m.
WINDY = (
    "wind.mean_mps=[-2.1,2.1]",
    "wind.gust_mps=0.5",
    "water.current_mps=[0.0,0.1]",
    "vessel.frontal_m2=0.03",
    "vessel.lateral_m2=0.06",
    "vessel.wind_x=0.7",
    "vessel.wind_y=0.8",
    "vessel.wind_n=0.1",
    "vessel.length_m=1.3",
)
FLEETS: dict[str, tuple[str, ...]] = {
    "diamond": ("diamond", "law=product"),
    "noisy": ("noisy",),
    "current": ("current",),
    "sea": ("sea",),
    "square": ("square",),
    "turning": ("turning",),
    "straight": ("straight",),
    "windy": ("noisy", *WINDY),
    **{name: ("mixed", *alike(name)) for name in presets.names()},
    "blueboat in weather": ("mixed", *alike("blueboat"), *WEATHER),
}


@dataclass(frozen=True)
class Told:
    """A boat's text, and when."""

    minute: float
    number: str
    text: str


@dataclass
class Learnt:
    """The reports of the boats of one run: texts and last values; and how well they sailed."""

    texts: dict[int, list[Told]] = field(default_factory=dict)
    values: dict[tuple[int, str], float] = field(default_factory=dict)
    rms_m: float = float("nan")
    left: str = ""


@dataclass(frozen=True)
class Wrong:
    """A fleet whose hull differs by `changes` in `number`, whose true value is `truth`."""

    fleet: str
    what: str
    changes: tuple[str, ...]
    number: str
    truth: float


def weak(fleet: str, port: float, stbd: float) -> Wrong:
    """Propellers that give these shares of the thrust in their parameters."""
    given = 0.5 * (port + stbd)
    own = scenario.load(*_file(fleet)).propellers
    changes = (
        f"propellers.port_gain={own.port_gain * port!r}",
        f"propellers.stbd_gain={own.stbd_gain * stbd!r}",
    )
    what = f"port {port:g}, starboard {stbd:g}"
    return Wrong(fleet, what, changes, BALANCE, 0.5 * (stbd - port) / given)


def times(fleet: str, number: str, factor: float) -> Wrong:
    """A hull with that many times the drag, or the yaw damping, of the boats' parameters."""
    own = scenario.load(*_file(fleet)).vessel
    keys = {DRAG: ("d11", "d11_quadratic"), YAW: ("d33", "d33_quadratic", "d33_speed")}[number]
    changes = tuple(f"vessel.{key}={getattr(own, key) * factor!r}" for key in keys)
    return Wrong(fleet, f"{keys[0]} × {factor:g}", changes, number, factor)


def preset_drag(name: str, factor: float) -> Wrong:
    """Four boats of a hull by name, with that many times its drag."""
    own = presets.load(name).vessel
    changes = tuple(
        f"boat.{boat}.vessel.{key}={getattr(own, key) * factor!r}"
        for boat in range(1, BOATS + 1)
        for key in ("d11", "d11_quadratic")
    )
    return Wrong(name, f"d11 × {factor:g}", changes, DRAG, factor)


def _file(fleet: str) -> tuple[str, list[str]]:
    name, *changes = FLEETS[fleet]
    return name, changes


def learnt(
    fleet: str,
    changes: Sequence[str],
    seeds: Sequence[int],
    minutes: float,
    parameters: dict[str, float] | None = None,
) -> list[Learnt]:
    """Sail a fleet once for each seed."""
    name, own = _file(fleet)
    more = [*own, *changes, f"duration_s={60 * minutes:g}"]
    chosen = [scenario.load(name, [*more, f"seed={seed}"]) for seed in seeds]
    out = [Learnt() for _ in chosen]
    mav = mavlink.MAVLink(None)
    begin_us: list[int] = []

    def watch(batch: Batch, members: Sequence[int], tick: int, t_us: int) -> None:
        if tick == 0:
            begin_us[:] = [t_us]
        minute = (t_us - begin_us[0]) / 60e6
        for run, member in enumerate(members):
            for agent in range(1, batch.boats + 1):
                sent = batch.fleet.sent(batch.row(run, agent))
                if b" min: " in sent or b"LRN_" in sent:
                    _hear(out[member], agent, minute, sent, mav)

    for one, run in zip(out, sail(chosen, parameters or {}, keep_s=0.1, watch=watch), strict=True):
        if not isinstance(run, Run):
            one.left = str(run)
            continue
        one.rms_m = worst_rms_m(run.trace["error"])
        ends = {state for states in run.states for state in states}
        one.left = " ".join(sorted(ends - {"FORMATION", "APPROACH"}))
    return out


def _hear(one: Learnt, agent: int, minute: float, sent: bytes, mav: mavlink.MAVLink) -> None:
    """Read texts and values from what a boat sent in a tick, on whichever link it came first."""
    for kind, _, _, frame in frames(sent):
        if kind == mavlink.MAVLINK_MSG_ID_STATUSTEXT:
            text = mav.decode(bytearray(frame)).text
            number = next((own for word, own in _WORDS.items() if word in text), None)
            texts = one.texts.setdefault(agent, [])
            if number is None or " min: " not in text:
                continue
            if not texts or texts[-1].text != text:
                texts.append(Told(minute, number, text))
        elif kind == mavlink.MAVLINK_MSG_ID_NAMED_VALUE_FLOAT:
            value = mav.decode(bytearray(frame))
            if value.name.startswith("LRN_"):
                one.values[agent, value.name] = value.value


def boats(fleet: str) -> int:
    """Boats in a run of a fleet."""
    return len(scenario.load(*_file(fleet)).boat)


@dataclass(frozen=True)
class Row:
    """A case over all seeds: shares and figures of the table."""

    found: float  # share of the boats that told the number
    minutes: tuple[float, float]  # until told: median, worst
    error: tuple[float, float]  # of the last value: median size, worst
    others: int  # texts of other numbers
    rms_m: float
    left: int  # runs in which a boat left FORMATION


def judged(case: Wrong, runs: Sequence[Learnt]) -> Row:
    """The figures of a case from its runs."""
    count = boats(case.fleet) * len(runs)
    every = [texts for run in runs for texts in run.texts.values()]
    first = [
        next(told.minute for told in texts if told.number == case.number)
        for texts in every
        if any(told.number == case.number for told in texts)
    ]
    off = [
        abs(value - case.truth)
        for run in runs
        for (_, name), value in run.values.items()
        if name == case.number
    ]
    others = sum(told.number != case.number for texts in every for told in texts)
    return Row(
        len(first) / count,
        _spread(first),
        _spread(off),
        others,
        max(run.rms_m for run in runs),
        sum(bool(run.left) for run in runs),
    )


def _spread(figures: Sequence[float]) -> tuple[float, float]:
    if not figures:
        return float("nan"), float("nan")
    return float(np.median(figures)), float(np.max(figures))


#: All that `main` sails of wrong hulls.
CASES = (
    *(weak(fleet, 0.88, 1.0) for fleet in ("noisy", "windy", "square", "sea")),
    weak("noisy", 1.0, 0.88),
    *(
        times(fleet, number, factor)
        for fleet in ("noisy", "windy", "sea")
        for number in (DRAG, YAW)
        for factor in (0.5, 2.0)
    ),
)


def _wrong(seeds: Sequence[int], minutes: float) -> None:
    heads = ("told by", "minutes: median; worst", "truth", "error: median; worst", "others told")
    print(f"| wrong | {' | '.join(heads)} | RMS, m | runs that left FORMATION |")
    print("|---|" + "--:|" * 7)
    for case in CASES:
        row = judged(case, learnt(case.fleet, case.changes, seeds, minutes))
        cells = [f"{row.found:.0%}", f"{row.minutes[0]:.1f}; {row.minutes[1]:.1f}"]
        cells += [f"{case.truth:.3f}", f"{row.error[0]:.3f}; {row.error[1]:.3f}", f"{row.others}"]
        cells += [f"{row.rms_m:.3f}", f"{row.left}"]
        print(f"| {case.fleet}: {case.what} | {' | '.join(cells)} |", flush=True)


def _right(seeds: Sequence[int], minutes: float) -> None:
    print("| nothing wrong | boats | false findings | such as |\n|---|--:|--:|---|")
    for fleet in FLEETS:
        texts = [
            told.text
            for run in learnt(fleet, (), seeds, minutes)
            for own in run.texts.values()
            for told in own
        ]
        cells = f"{boats(fleet) * len(seeds)} | {len(texts)} | {''.join(texts[:1])}"
        print(f"| {fleet} | {cells} |", flush=True)


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    tables = {"wrong": _wrong, "right": _right}
    parser.add_argument("--only", choices=tables, help="one of the two tables")
    parser.add_argument("--seeds", type=int, default=20, help="of each case (20)")
    parser.add_argument("--minutes", type=float, default=10.0, help="of each run (10)")
    options = parser.parse_args()
    for name in [options.only] if options.only else tables:
        tables[name](range(1, options.seeds + 1), options.minutes)


if __name__ == "__main__":
    main()
