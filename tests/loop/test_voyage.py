# SPDX-License-Identifier: MIT
"""The voyage that measures a hull, in the loop: its room, its end, and what stops it.

Whole voyages of 25 minutes are sailed with --all; tests/app/plan/test_voyage.cpp sails them on each
push, without the loop.
"""

import csv
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import flotilla
import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from sil.lockstep.batch import Batch
from sil.lockstep.recording import MAVLINK_IN, Recording
from sil.lockstep.world import all_sailed, sail
from sil.logs import own_motion
from sil.scenario import scenario
from sil.wire.heartbeat import AUTO, MANUAL
from sil.wire.mavlink_frames import frames
from sil.wire.operator import Operator, mode_request

CENTRE = np.array([5.0, 0.0])
ROOM_M = 60.0
STEPS = 42
BREEZE = ["water.current_mps=[0.07, 0.07]", "wind.mean_mps=[0.0, 3.0]", "wind.gust_mps=1.0"]
#: Full thrust ahead in step 2 of calm water from this time on, s.
AHEAD_S = 72.0

#: A firmware that knows every number of the hull 30 % wrong.
WRONG = {
    "VES_M11": 31.0,
    "VES_M22": 27.0,
    "VES_M33": 4.0,
    "VES_D11": 17.0,
    "VES_D22": 49.0,
    "VES_D33": 12.0,
}

Meddle = Callable[[Batch, int, float, int], None]


@dataclass
class Sailed:
    """A boat's texts with their times (s), its states and commands at every tick, its positions."""

    texts: list[tuple[float, str]] = field(default_factory=list)
    reached: list[int] = field(default_factory=list)
    states: list[str] = field(default_factory=list)
    commands: list[Any] = field(default_factory=list)
    places: list[Any] = field(default_factory=list)

    def time_of(self, begin: str) -> float:
        return next(t for t, text in self.texts if text.startswith(begin))

    def steps(self) -> list[int]:
        begun = [text.split()[2] for _, text in self.texts if " of 42, " in text]
        return [int(number) for number in begun if number.isdigit()]


def sail_voyages(
    overrides: Sequence[Sequence[str]],
    parameters: dict[str, float] | None = None,
    meddle: Meddle | None = None,
    record: Path | None = None,
) -> list[Sailed]:
    """Sail the scenario with these overrides, a run each; a broken rule of the firmware raises."""
    chosen = [scenario.load("voyage", one) for one in overrides]
    told = [Sailed() for _ in chosen]
    mav = mavlink.MAVLink(None)
    begin_us: list[int] = []

    def watch(batch: Batch, members: Sequence[int], tick: int, t_us: int) -> None:
        if tick == 0:
            begin_us[:] = [t_us]
        t_s = 1e-6 * (t_us - begin_us[0])
        for run, member in enumerate(members):
            one, agent = told[member], batch.row(run, 1)
            for kind, _, _, frame in frames(batch.fleet.sent(agent)):
                if kind == mavlink.MAVLINK_MSG_ID_STATUSTEXT:
                    one.texts.append((t_s, mav.decode(bytearray(frame)).text))
                elif kind == mavlink.MAVLINK_MSG_ID_MISSION_ITEM_REACHED:
                    one.reached.append(mav.decode(bytearray(frame)).seq)
            one.states.append(flotilla.STATES[int(batch.states[run, 0])])
            one.commands.append(batch.command[run * batch.boats].copy())
            one.places.append(batch.bodies.eta[agent, :2].copy())
            if meddle is not None:
                meddle(batch, agent, t_s, t_us)

    all_sailed(
        sail(chosen, {**WRONG, **(parameters or {})}, keep_s=0.1, watch=watch, record=record)
    )
    return told


def farthest_m(one: Sailed) -> float:
    return float(np.hypot(*(np.array(one.places) - CENTRE).T).max())


@pytest.mark.parametrize(
    ("weather", "longest_s"),
    [
        pytest.param([], 1680.0, id="calm", marks=pytest.mark.nightly),
        pytest.param(BREEZE, 1800.0, id="breeze", marks=pytest.mark.nightly),
    ],
)
def test_a_boat_measures_its_hull_within_its_room_in_about_25_minutes(
    weather: list[str], longest_s: float
) -> None:
    (one,) = sail_voyages([[*weather, "duration_s=1860"]])
    assert set(one.states) == {"AUTO"}
    assert sorted(set(one.steps())) == list(range(1, STEPS + 1))
    assert one.steps() == sorted(one.steps())
    over_s = one.time_of("Voyage: over")
    print(f"over after {over_s:.0f} s, at most {farthest_m(one):.1f} m from the centre")
    assert 1200.0 < over_s < longest_s
    assert farthest_m(one) < ROOM_M
    assert one.reached == [1]
    # No push in its drifts, both propellers' whole travel in between.
    commands = np.array(one.commands)
    assert not commands[1000:6000].any()
    assert commands.max() > 0.5
    assert commands.min() < -0.5


def test_a_step_that_a_gust_cuts_off_is_repeated() -> None:
    def gust(batch: Batch, agent: int, t_s: float, t_us: int) -> None:
        if 10.0 < t_s < 60.0 and batch.bodies.eta[agent, 1] < 59.0:
            batch.bodies.eta[agent, 1] += 1.4e-6 * batch.h_us

    (one,) = sail_voyages([["duration_s=260"]], meddle=gust)
    again_s = one.time_of("Voyage: step 1 again: no room")
    assert 30.0 < again_s < 60.0
    assert one.steps()[:3] == [1, 1, 2]
    assert farthest_m(one) < ROOM_M
    assert set(one.states) == {"AUTO"}


def test_the_circle_round_home_is_never_left() -> None:
    (one,) = sail_voyages([["duration_s=300"]], {"FS_FENCE_M": 25.0})
    assert set(one.states) == {"AUTO"}
    assert float(np.hypot(*np.array(one.places).T).max()) < 25.0
    assert any(text.endswith(": the fence") for _, text in one.texts)


FAULTS = {  # kind: value, seconds until the propellers stand still
    "own_silent": (0.0, 0.6),
    "own_frozen": (0.0, 1.0),
    "own_jump": (30.0, 0.2),
    "own_poor_fix": (0.0, 1.1),
    "esc_silent": (0.0, 1.3),
    "bus_off": (0.0, 0.3),  # the ESCs stop by themselves
    "stop_switch": (0.0, 0.2),
    "esc_voltage": (9.0, 3.0),
    "gcs_silent": (0.0, 3.2),
}
LIMITS = {"FS_BATT_V": 10.0, "FS_GCS_S": 2.0}


@pytest.mark.parametrize("kind", FAULTS)
def test_every_fault_stops_the_propellers(kind: str) -> None:
    value, within_s = FAULTS[kind]
    fault = f'fault=[{{kind="{kind}", agent=1, at_s={AHEAD_S}, value={value}}}]'
    (one,) = sail_voyages([["duration_s=85", fault]], LIMITS)
    commands = np.abs(np.array(one.commands)).max(axis=1)
    at = round(100 * AHEAD_S)
    assert one.states[at - 1] == "AUTO"
    assert commands[at - 1] > 0.2
    assert not commands[at + round(100 * within_s) :].any()
    assert one.states[-1] in {"HOLD", "FAULT"}


def test_sticks_take_over_and_the_voyage_goes_on_with_its_step() -> None:
    pilot = Operator()

    def take_over(batch: Batch, agent: int, t_s: float, t_us: int) -> None:
        tick = round(100 * t_s)
        if AHEAD_S <= t_s < 80.0 and tick % 10 == 0:
            ahead = 0.0 if t_s < 76.0 else -0.5
            batch.fleet.hear(agent, pilot.sticks(1, ahead), t_us)
        if tick == round(100 * AHEAD_S) + 20:
            batch.fleet.command([agent], t_us, *mode_request(MANUAL))
        if tick == 8200:
            batch.fleet.command([agent], t_us, *mode_request(AUTO))

    (one,) = sail_voyages([["duration_s=100"]], meddle=take_over)
    commands = np.array(one.commands)
    assert one.states[7190] == "AUTO"
    assert one.states[7230] == "MANUAL"
    assert commands[7150].min() > 0.2
    assert not commands[7235:7590].any()
    assert (commands[7700:7990] < 0.0).all()
    assert one.states[8300] == "AUTO"
    assert one.steps() == [1, 2, 2]


def test_the_table_has_the_measurements_and_the_commands(tmp_path: Path) -> None:
    record = tmp_path / "recording.bin"
    (one,) = sail_voyages([["duration_s=120"]], record=record)
    rows = list(own_motion.of_run(record, 1))
    path = tmp_path / "motion1.csv"
    assert own_motion.write(path, rows) == len(rows)
    with path.open(encoding="ascii", newline="") as file:
        table = list(csv.DictReader(file))
    assert len(table) == len(rows)
    assert len(rows) > 20 * 120
    t_s = np.array([float(row["t_s"]) for row in table])
    assert np.diff(t_s) == pytest.approx(0.05, abs=0.011)
    # Truth at the same tick, within the unit's noise; the table begins before the release.
    wires = [(t_us, where, data) for t_us, where, data in Recording(record) if where >> 8 == 1]
    begin_us = next(
        t_us
        for t_us, where, data in wires
        if where & 0xFF == MAVLINK_IN
        and any(kind == mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED for kind, *_ in frames(data))
    )
    last_us = max(t_us for t_us, _, _ in wires)
    at = np.rint(100 * t_s).astype(int) - (last_us - begin_us) // 10_000 + len(one.places) - 1
    after = at > 0
    north = np.array([float(row["north_m"]) for row in table])[after]
    truth = np.array(one.places)[at[after], 0]
    assert north == pytest.approx(truth, abs=0.3)
    assert north.std() > 1.0
    port = np.array([float(row["port"]) for row in table])[after]
    sent = np.array(one.commands)[at[after] - 1, 0]  # of the tick before
    assert port == pytest.approx(sent, abs=0.002)
    assert port.max() > 0.2
