# SPDX-License-Identifier: MIT
"""RawCommand: slots, directions, limits; exactly zero unless in FORMATION."""

from __future__ import annotations

from itertools import pairwise

import dronecan
import pytest
from dronecan.transport import Transfer, TransferError
from hypothesis import given
from hypothesis import strategies as st

from tests.target.bus import FULL_SCALE, RAW_COMMAND, commands, of_type, slots, to_wire
from tests.target.course import Course
from tests.target.sea import PAPER, Sea, seeded
from tests.target.stations import FORMATION, HOLD

FAR_AHEAD, FAR_ASTERN = Course(190.0), Course(-190.0)


@seeded()
@given(st.lists(st.integers(-8192, 8191), max_size=4), st.integers(0, 31))
def test_the_decoder_of_these_tests_reads_what_dronecan_writes(raw: list[int], number: int) -> None:
    payload = dronecan.uavcan.equipment.esc.RawCommand(cmd=raw)
    ((_, data),) = to_wire(Transfer(number, 20, payload=payload, transfer_priority=8))
    assert slots(data[:-1]) == tuple(raw)


def test_both_propellers_are_commanded_in_every_tick(outing: Sea) -> None:
    for tick in outing.ticks:
        assert len(of_type(tick.can, RAW_COMMAND)) == 1
        assert len(tick.commands) == 2
        assert all(-FULL_SCALE <= c <= FULL_SCALE for c in tick.commands)
    assert any(tick.commands != (0, 0) for tick in outing.ticks)


def sail(parameters: dict[str, float], leader: Course, seconds: float = 3.0) -> Sea:
    sea = Sea(parameters, own=Course(), leader=leader)
    sea.enter_formation()
    sea.run(seconds)
    assert sea.state == "FORMATION"
    return sea


@pytest.mark.parametrize(
    ("port", "stbd"),
    [(0, 1), (1, 0), (2, 3), (0, 4), (3, 2), (0, 5), (7, 6), (19, 0), (0, 19), (18, 19)],
)
def test_the_slots_are_those_of_esc_port_and_esc_stbd(port: int, stbd: int) -> None:
    parameters: dict[str, float] = {"ESC_PORT": port, "ESC_STBD": stbd}
    sea = sail(parameters, Course(6.0, 2.0, 1.0))
    reference = sail({}, Course(6.0, 2.0, 1.0))
    assert len(sea.commands) > max(port, stbd)
    assert (sea.commands[port], sea.commands[stbd]) == reference.commands != (0, 0)
    assert reference.commands[0] != reference.commands[1]
    assert not any(c for k, c in enumerate(sea.commands) if k not in (port, stbd))
    frames = of_type(sea.ticks[-1].can, RAW_COMMAND)
    assert (len(frames) > 1) == (max(port, stbd) > 3)
    sea.disarm()
    assert sea.state == "DISARMED" and not any(sea.commands)


@pytest.mark.parametrize(("port", "stbd"), [(1, 1), (-1, 1), (1, -1), (-1, -1)])
def test_a_propeller_that_turns_the_other_way_gets_the_opposite_command(
    port: int, stbd: int
) -> None:
    plain = sail({}, Course(6.0, 2.0, 1.0))
    turned = sail({"THR_PORT_DIR": port, "THR_STBD_DIR": stbd}, Course(6.0, 2.0, 1.0))
    for a, b in zip(plain.ticks, turned.ticks, strict=True):
        assert b.commands == (port * a.commands[0], stbd * a.commands[1])
    assert plain.commands != (0, 0)


@pytest.mark.parametrize(("leader", "full"), [(FAR_AHEAD, FULL_SCALE), (FAR_ASTERN, -FULL_SCALE)])
@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("expo", [0.0, 0.5, 1.0])
def test_full_thrust_is_8191_either_way(
    leader: Course, full: int, direction: int, expo: float
) -> None:
    # The published law, which has no speed limit, demands it.
    directions = {"THR_PORT_DIR": direction, "THR_STBD_DIR": direction}
    sea = sail(PAPER | directions | {"THR_EXPO": expo}, leader)
    assert sea.commands == (direction * full, direction * full)
    assert all(abs(c) <= FULL_SCALE for tick in sea.ticks for c in tick.commands)
    assert sea.snapshot()["limited"]["surge"]


def test_port_thrust_turns_to_starboard() -> None:
    """The leader's heading is to starboard of ours: port ahead, starboard astern."""
    sea = sail(
        {"LAW_KPSI": 2.0, "THR_FWD_MAX": 5.0, "THR_REV_MAX": 5.0}, Course(0.0, 0.0, 1.0), 1.0
    )
    port, stbd = sea.commands
    assert port > 0 > stbd


def test_commands_follow_the_slew_limit_and_stopping_does_not() -> None:
    sea = Sea({"THR_SLEW": 1.0} | PAPER, own=Course(), leader=FAR_AHEAD)
    sea.enter_formation()
    first = len(sea.ticks)
    sea.run(2.0)
    speeds = [t.commands[0] for t in sea.ticks[first:]]
    steps = [b - a for a, b in pairwise(speeds)]
    assert max(steps) <= FULL_SCALE * 0.01 + 1 and speeds[-1] == FULL_SCALE
    sea.disarm()
    assert sea.commands == (0, 0)


def test_without_slew_limit_full_thrust_comes_at_once() -> None:
    sea = Sea({"THR_SLEW": 0.0} | PAPER, own=Course(), leader=FAR_AHEAD)
    sea.enter_hold()
    sea.run(0.2)
    assert sea.mode(FORMATION).commands == (FULL_SCALE, FULL_SCALE)


def test_a_thrust_within_the_dead_band_is_exactly_zero() -> None:
    sea = sail(
        {"THR_DEAD": 15.0, "THR_FWD_MAX": 100.0, "THR_REV_MAX": 100.0}, Course(0.5, 0.0, 0.0)
    )
    assert sea.snapshot()["wrench_asked"]["X_N"] != 0.0
    assert sea.commands == (0, 0)


@pytest.mark.parametrize(
    "parameters", [{}, {"ESC_PORT": 17, "ESC_STBD": 3, "THR_PORT_DIR": -1}], ids=str
)
def test_disarmed_and_holding_boats_command_exactly_zero_in_every_slot(
    parameters: dict[str, float],
) -> None:
    sea = Sea(parameters, own=Course(), leader=FAR_AHEAD)
    sea.run(2.0)
    sea.arm()
    sea.run(2.0)
    sea.mode(FORMATION)
    sailed = len(sea.ticks)
    sea.run(2.0)
    sea.mode(HOLD)
    stopped = len(sea.ticks) - 1
    sea.run(1.0)
    sea.disarm()
    sea.run(1.0)
    quiet = [*sea.ticks[: sailed - 1], *sea.ticks[stopped:]]
    assert not any(any(tick.commands) for tick in quiet)
    assert any(any(tick.commands) for tick in sea.ticks[sailed:stopped])
    frames = [data for tick in quiet for _, data in of_type(tick.can, RAW_COMMAND)]
    alone = [data for data in frames if data[-1] & 0xC0 == 0xC0]  # the transfer's only frame
    assert bool(alone) == (len(sea.commands) <= 4)
    assert not any(any(data[:-1]) for data in alone)


def test_the_oracle_refuses_a_damaged_command() -> None:
    """Checks the oracle: dronecan detects a wrong transfer CRC."""
    sea = Sea({"ESC_STBD": 19})
    frames = of_type(sea.step().can, RAW_COMMAND)
    assert not any(commands(frames)) and len(commands(frames)) == 20
    frames[1] = (frames[1][0], b"\x01" + frames[1][1][1:])
    with pytest.raises(TransferError):
        commands(frames)
