# SPDX-License-Identifier: MIT
"""Faults of a scenario happen at their ticks, depend on the seed, and can be replayed."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import flotilla
import numpy as np
import pytest

from sil.faults.rows import State
from sil.lockstep.batch import Batch
from sil.lockstep.recording import HOST, MAVLINK_IN, Recording
from sil.lockstep.replay import replay
from sil.lockstep.timeline import check
from sil.lockstep.world import Run, sail
from sil.plant.sensors import SensorNoise
from sil.scenario import scenario
from sil.scenario.fault_errors import fault_contradictions
from sil.scenario.fault_kinds import KINDS
from sil.scenario.scenario import Scenario, ScenarioError
from sil.scenario.sections import Fault
from tests.target.troubled_fleet import messages

PAIR = Path(__file__).parents[3] / "sil" / "faults" / "pair.toml"
OLD = ("clocks.offset_s=1e6",)


def sailing(*lines: dict[str, Any], overrides: Sequence[str] = (), s: float = 4.0) -> Scenario:
    source = scenario.read(PAIR, [f"duration_s={s}", *overrides])
    source.document["fault"] = list(lines)
    return scenario.check(source)


def states_of(one: Scenario, boat: int) -> list[tuple[int, str]]:
    """Tick and state of each change."""
    changes: list[tuple[int, str]] = []

    def watch(batch: Batch, _: Sequence[int], tick: int, __: int) -> None:
        state = flotilla.STATES[batch.states[0, boat - 1]]
        if not changes or changes[-1][1] != state:
            changes.append((tick, state))

    sail([one], {}, watch=watch)
    return changes


def refused(agent: int, kind: str, value: float) -> bool:
    """Whether a `flotilla.Fleet` of a leader and a boat refuses the fault."""
    fleet = flotilla.Fleet()
    unit, exact = (100.0, "local", 0.0), (0, 0.0)
    fleet.add_leader(0, 100, unit, exact)
    fleet.add_boat(0, {"MAV_SYSID": 1}, unit, exact)
    try:
        fleet.set_fault(agent, kind, 0, value)
    except ValueError:
        return True
    return False


@pytest.mark.parametrize("kind", [one.name for one in KINDS.values() if one.owner != "world"])
def test_a_scenario_refuses_a_fault_where_the_firmware_does(kind: str) -> None:
    def contradicts(agent: int, value: float) -> bool:
        line = {"kind": kind, "agent": agent, "at_s": 9.0, "value": value}
        problems = fault_contradictions([Fault.model_validate(line)], 1, SensorNoise())
        return any(f"{kind} takes no value" not in problem for _, problem in problems)

    for agent, value in ((0, 0.5), (1, 0.5), (1, 2.0)):
        assert contradicts(agent, value) == refused(agent, kind, value), (agent, value)


def test_a_row_of_the_matrix_names_the_firmwares_states() -> None:
    assert get_args(State) == flotilla.STATES


def test_a_fault_begins_and_ends_at_its_ticks() -> None:
    killed = {"kind": "restart", "agent": 1, "at_s": 1.0, "for_s": 0.5}
    assert states_of(sailing(killed), 1)[:2] == [(0, "FORMATION"), (100, "DISARMED")]
    silent = {"kind": "bus_off", "agent": 2, "at_s": 0.0, "for_s": 1.0}
    assert states_of(sailing(silent), 2)[:2] == [(0, "FORMATION"), (1, "FAULT")]


def test_faults_may_follow_each_other_and_last_at_least_a_tick() -> None:
    ends = {"kind": "bus_off", "agent": 2, "at_s": 0.5, "for_s": 0.5}
    begins = {"kind": "bus_off", "agent": 2, "at_s": 1.0, "for_s": 0.5}
    bus = [bus_up(sailing(*lines), 2) for lines in ([ends, begins], [begins, ends])]
    assert bus == [[(0, True), (50, False), (150, True)]] * 2
    assert bus_up(sailing({**ends, "for_s": 1e-9}), 2) == [(0, True), (50, False), (51, True)]


def bus_up(one: Scenario, boat: int) -> list[tuple[int, bool]]:
    """Tick and value of each change of that condition."""
    changes: list[tuple[int, bool]] = []

    def watch(batch: Batch, _: Sequence[int], tick: int, __: int) -> None:
        up = batch.fleet.snapshot(batch.row(0, boat))["conditions"]["bus_up"]
        if not changes or changes[-1][1] != up:
            changes.append((tick, up))

    sail([one], {}, watch=watch)
    return changes


def test_a_replay_doubles_the_traffic_from_its_time_on(tmp_path: Path) -> None:
    told = {"kind": "replay", "agent": 1, "at_s": 2.0, "value": 1.0}
    sizes: list[list[int]] = []
    for lines in ([], [told]):
        file = tmp_path / "recording.bin"
        sail([sailing(*lines)], {}, record=file)
        chunks = [(t, data) for t, port, data in Recording(file) if port == (2 << 8) + 1]
        sizes.append([sum(len(d) for t, d in chunks if lo <= t < hi) for lo, hi in _halves(file)])
    (well_before, well_after), (before, after) = sizes
    assert before == well_before
    assert after > 1.8 * well_after


def _halves(file: Path) -> list[tuple[int, int]]:
    """Begin and end, us, of the third-last and the second-last second of a recording."""
    last = max(t for t, _, _ in Recording(file))
    return [(last - 3_000_000, last - 2_000_000), (last - 2_000_000, last - 1_000_000)]


def test_runs_with_faults_replay_bit_for_bit(tmp_path: Path) -> None:
    """Also for a boat that was killed, whose clock jumped, or whose bus was off."""
    lines = [
        {"kind": "restart", "agent": 1, "at_s": 0.5, "for_s": 0.5},
        {"kind": "bus_off", "agent": 2, "at_s": 0.5, "for_s": 0.5},
        {"kind": "bus_off", "agent": 1, "at_s": 0.7, "for_s": 2.0},
        {"kind": "clock", "agent": 2, "at_s": 1.5, "for_s": 1.0, "value": -3600.0},
        {"kind": "byte_errors", "agent": 1, "at_s": 2.0, "value": 0.01},
        {"kind": "frame_loss", "agent": 2, "at_s": 2.0, "value": 0.3},
    ]
    file = tmp_path / "recording.bin"
    (run,) = sail([sailing(*lines, overrides=OLD)], {}, record=file)
    assert isinstance(run, Run)
    recording = Recording(file)
    assert replay(recording) == [-1, -1]
    assert recording.digest() == run.digest
    events = [(port >> 8, data[0]) for _, port, data in recording if port & 0xFF == HOST]
    assert events.count((1, 2)) == 1 and events.count((2, 1)) == 2


@pytest.mark.parametrize("kind", ["frame_loss", "radio_loss", "byte_errors"])
def test_which_frames_are_lost_depends_only_on_the_seed(kind: str) -> None:
    line = {"kind": kind, "agent": 1, "at_s": 0.5, "value": 0.1}
    digests = [
        run.digest
        for overrides in ((), (), ("seed=4",))
        for run in sail([sailing(line, overrides=overrides, s=2.0)], {}, digest=True)
        if isinstance(run, Run)
    ]
    assert digests[0] == digests[1] != digests[2]


def test_a_fault_changes_its_own_run_only() -> None:
    line = {"kind": "own_jump", "agent": 1, "at_s": 0.5, "value": 5.0}
    alone = sail([sailing(s=2.0)], {}, digest=True)
    together = sail([sailing(line, s=2.0), sailing(s=2.0)], {}, digest=True)
    digests = [run.digest for run in (*alone, *together) if isinstance(run, Run)]
    assert digests[0] == digests[2] != digests[1]


def test_own_noisy_multiplies_the_units_noise(tmp_path: Path) -> None:
    line = {"kind": "own_noisy", "agent": 2, "at_s": 10.0, "value": 10.0}
    file = tmp_path / "recording.bin"
    (run,) = sail([sailing(line, s=20.0)], {}, record=file)
    assert isinstance(run, Run)
    chunks = [(t, data) for t, port, data in Recording(file) if port == (2 << 8) + MAVLINK_IN]
    told = np.array([m.x for m in messages(chunks, "LOCAL_POSITION_NED")][-400:])
    rough = np.std(np.diff(told[:190], 2)), np.std(np.diff(told[-190:], 2))
    assert rough[1] / rough[0] == pytest.approx(10.0, rel=0.3)


def test_a_clock_is_not_turned_back_to_before_its_beginning() -> None:
    line = {"kind": "clock", "agent": 1, "at_s": 0.5, "value": -3600.0}
    with pytest.raises(ValueError, match="fault 1: agent 1's clock would be turned back"):
        check(sailing(line))
    check(sailing(line, overrides=OLD))


MISTAKES = [
    ({"kind": "own_sick"}, "must be 'own_silent', "),
    ({"agent": 3}, '"fault.1.agent" = 3: there are agents 0 to 2'),
    ({"kind": "esc_stuck", "agent": 0}, "the virtual leader cannot have esc_stuck"),
    ({"esc": "port"}, '"fault.1.esc" = "port": own_silent is not a fault of ESCs'),
    ({"value": 1.0}, '"fault.1.value" = 1.0: own_silent takes no value'),
    ({"kind": "own_jump"}, "own_jump needs a value"),
    ({"kind": "radio_loss", "value": 1.5}, "radio_loss takes a value from 0 to 1 (share)"),
    ({"kind": "own_jump", "value": 1e7}, "own_jump takes a value from -1e+06 to 1e+06 (m)"),
    ({"kind": "replay", "value": 3.0}, "at most at_s"),
    ({"kind": "own_noisy", "value": -1.0}, "own_noisy takes a value from 0 to 1e+06 (factor)"),
    ({"for_s": 0.0}, "greater than 0"),
    ({"at_s": -1.0}, "greater than or equal to 0"),
    ({"when_s": 1.0}, 'unknown key "fault.1.when_s"'),
]


@pytest.mark.parametrize(("wrong", "words"), MISTAKES)
def test_mistakes_are_reported_with_their_key(wrong: dict[str, Any], words: str) -> None:
    line = {"kind": "own_silent", "agent": 1, "at_s": 2.0, **wrong}
    with pytest.raises(ScenarioError) as error:
        sailing(line)
    assert words in str(error.value) and "\n" not in str(error.value)


SAME = "overlaps fault 1, of the same kind and agent"


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"at_s": 1.5}, SAME),
        ({"at_s": 0.5, "for_s": 9.0}, SAME),
        ({"esc": "both"}, SAME),
        ({"at_s": 2.0}, ""),
        ({"esc": "stbd"}, ""),
        ({"agent": 2}, ""),
        ({"kind": "esc_stuck"}, ""),
    ],
)
def test_a_fault_does_not_happen_twice_at_a_time(changes: dict[str, Any], words: str) -> None:
    """The end of one would also end the other."""
    line = {"kind": "esc_silent", "agent": 1, "at_s": 1.0, "for_s": 1.0, "esc": "port"}
    if not words:
        sailing(line, {**line, **changes})
        return
    with pytest.raises(ScenarioError, match=words):
        sailing(line, {**line, **changes})


def test_own_noisy_needs_a_unit_with_noise() -> None:
    line = {"kind": "own_noisy", "agent": 1, "at_s": 2.0, "value": 10.0}
    quiet = [f"navigation.{name}=0.0" for name in ("position_noise_m", "heading_noise_rad")]
    quiet += [f"navigation.{name}=0.0" for name in ("velocity_noise_mps", "yaw_rate_noise_radps")]
    with pytest.raises(ScenarioError, match="no noise to multiply"):
        sailing(line, overrides=quiet)


def test_gcs_silent_interrupts_the_ground_stations_heartbeats(tmp_path: Path) -> None:
    line = {"kind": "gcs_silent", "agent": 1, "at_s": 2.0, "for_s": 2.5}
    waits = "parameters.FS_GCS_S=60.0"
    file = tmp_path / "recording.bin"
    (run,) = sail([sailing(line, overrides=[waits], s=6.0)], {}, record=file)
    assert isinstance(run, Run)
    assert replay(Recording(file)) == [-1, -1]
    beats = []
    for boat in (1, 2):
        chunks = [(t, d) for t, port, d in Recording(file) if port == (boat << 8) + MAVLINK_IN + 1]
        times = [t for t, d in chunks for m in messages([(t, d)], "HEARTBEAT") if m.type == 6]
        beats.append(times)
    assert np.diff(beats[1]).tolist() == [1_000_000] * (len(beats[1]) - 1)
    assert len(beats[1]) - len(beats[0]) in (2, 3)
    assert max(np.diff(beats[0])) >= 3_000_000
