# SPDX-License-Identifier: MIT
"""What keeps a boat from doing harm: silence, faults, strange clocks, strangers, noise."""

from __future__ import annotations

import math
import random
from itertools import pairwise
from typing import Any

import flotilla
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from tests.target.harness import (
    ARM,
    BOAT,
    ESC_STATUS,
    FORCE,
    FORMATION,
    FULL_SCALE,
    HOLD,
    LEADER,
    NAVIGATION,
    NODE_STATUS,
    SET_MODE,
    START_US,
    STRANGER,
    Course,
    Sea,
    Station,
    Tick,
    arming_statuses,
    attitude,
    command_long,
    commands,
    heartbeat,
    local_position,
    odometry,
    origin,
    seeded,
    texts,
)

TURN = Course(4.0, 3.0, 0.5, 0.6, 0.0, 0.2)  # a leader that keeps every propeller busy
LIMITS = {
    "own": ("FS_NAV_S", "own state"),
    "leader": ("FS_LEADER_S", "leader"),
    "escs": ("FS_ESC_S", "ESC"),
}


def assert_finite(value: Any) -> None:
    if isinstance(value, dict):
        for each in value.values():
            assert_finite(each)
    elif isinstance(value, float):
        assert math.isfinite(value)


def at_sea(parameters: dict[str, float] | None = None, **how: Any) -> Sea:
    """In FORMATION for a second, propellers turning."""
    sea = Sea(parameters, leader=TURN, **how)
    sea.enter_formation()
    sea.run(1.0)
    assert sea.state == "FORMATION" and all(sea.commands)
    return sea


def silence(sea: Sea, who: str) -> int:
    """Nothing more from them; the time of the last word that the boat has heard."""
    if who == "escs":
        said = sea.escs[0].sent
        while sea.escs[0].sent == said:
            sea.step()
        sea.escs[1].on = False
    else:
        agent = getattr(sea, who)
        due_us = agent.next_us
        while agent.next_us == due_us:
            sea.step()
        agent.on = False
    return sea.ticks[-1].now_us


# --- silence -------------------------------------------------------------------------------------


@pytest.mark.parametrize("who", LIMITS)
@pytest.mark.parametrize("rate", [50, 100, 333])
@pytest.mark.parametrize("limit_s", [0.3, 1.0, 2.0])
def test_propellers_stop_within_one_tick_of_the_time_limit(
    who: str, rate: int, limit_s: float
) -> None:
    sea = at_sea({LIMITS[who][0]: limit_s, "CTL_RATE": rate})
    last_us = silence(sea, who)
    for _ in range(round((limit_s + 0.5) * rate)):
        tick = sea.step()
        age_us = tick.now_us - last_us
        if age_us < limit_s * 1e6 - sea.period_us:
            assert any(tick.commands), f"stopped early, after {age_us} us"
        if age_us >= limit_s * 1e6 + sea.period_us:
            assert not any(tick.commands), f"still turning after {age_us} us"


@pytest.mark.parametrize("who", LIMITS)
def test_a_boat_that_stops_says_state_and_reason(who: str) -> None:
    sea = at_sea()
    silence(sea, who)
    sea.ticks.clear()
    sea.run(1.5)
    expected = "FAULT" if who == "escs" else "HOLD"
    assert sea.state == expected
    (said,) = texts(sea.ticks)
    assert said.startswith(expected + ": ") and LIMITS[who][1] in said and len(said) <= 50
    (tick,) = [t for t in sea.ticks if t.named("STATUSTEXT")]
    assert not any(tick.commands), "said in the very tick that stops"
    beat = tick.named("HEARTBEAT")[-1]
    assert beat.custom_mode == HOLD
    assert beat.system_status == (6 if who == "escs" else 4)
    assert tick.named("STATUSTEXT")[0].severity <= 4


def test_arming_status_is_zero_in_the_tick_of_a_fault() -> None:
    sea = at_sea()
    silence(sea, "escs")
    while sea.state != "FAULT":
        tick = sea.step()
    assert arming_statuses(tick.can) == [0] and not any(tick.commands)
    assert {s for t in sea.run(1.0) for s in arming_statuses(t.can)} == {0}


@pytest.mark.parametrize("who", ["own", "leader"])
def test_hold_stays_when_they_speak_again(who: str) -> None:
    sea = at_sea()
    silence(sea, who)
    sea.run(1.5)
    getattr(sea, who).on = True
    ticks = sea.run(10.0)
    assert sea.state == "HOLD" and not any(any(t.commands) for t in ticks)
    sea.mode(FORMATION)
    sea.run(1.0)
    assert sea.state == "FORMATION" and any(sea.commands)


@pytest.mark.parametrize("who", ["own", "leader"])
def test_a_gap_shorter_than_the_limit_changes_nothing(who: str) -> None:
    sea = at_sea()
    for _ in range(10):
        getattr(sea, who).on = False
        sea.run(0.4)
        getattr(sea, who).on = True
        ticks = sea.run(0.3)
        assert sea.state == "FORMATION" and all(any(t.commands) for t in ticks)


def test_fault_is_latched_until_the_operator_disarms() -> None:
    sea = at_sea()
    silence(sea, "escs")
    sea.run_until("FAULT", 2.0)
    sea.escs[1].on = True
    sea.ticks.clear()
    sea.run(20.0)
    for order in ((SET_MODE, 1.0, 6.0), (SET_MODE, 1.0, 4.0), (ARM, 1.0), (ARM, 1.0, float(FORCE))):
        tick = sea.order(*order)
        assert [m.result for m in tick.named("COMMAND_ACK")] != [0]
        sea.run(0.2)
        assert sea.state == "FAULT"
    assert not any(any(t.commands) for t in sea.ticks)
    assert {s for t in sea.ticks for s in arming_statuses(t.can)} == {0}
    sea.disarm()
    assert sea.state == "DISARMED"
    sea.run(1.0)
    assert sea.state == "DISARMED"
    sea.arm()
    assert sea.state == "HOLD" and not any(sea.commands)


def test_a_fault_while_holding_is_latched_too() -> None:
    sea = Sea()
    sea.enter_hold()
    silence(sea, "escs")
    sea.run_until("FAULT", 2.0)
    sea.escs[1].on = True
    sea.run(5.0)
    assert sea.state == "FAULT"


def test_all_silent_at_once_is_a_stopped_boat() -> None:
    sea = at_sea()
    sea.own.on = sea.leader.on = sea.escs[0].on = sea.escs[1].on = False
    sea.run(1.3)
    assert sea.state in ("HOLD", "FAULT") and not any(sea.commands)
    ticks = sea.run(600.0)
    assert not any(any(t.commands) for t in ticks)
    assert sea.state == "FAULT"


def test_disarming_stops_in_the_same_tick() -> None:
    sea = at_sea()
    tick = sea.disarm()
    assert sea.state == "DISARMED" and tick.commands == (0, 0)
    assert arming_statuses(tick.can)[-1] == 0


def test_a_boat_never_starts_armed_nor_moves_by_itself() -> None:
    sea = Sea(leader=TURN)
    ticks = sea.run(60.0)
    assert sea.state == "DISARMED" and {t.commands for t in ticks} == {(0, 0)}


ORDERS: list[tuple[int, float, float]] = [
    (ARM, 1.0, math.nan),
    (ARM, 1.0, float(FORCE)),
    (ARM, 0.0, math.nan),
    (SET_MODE, 1.0, 6.0),
    (SET_MODE, 1.0, 6.0),
]


@pytest.mark.parametrize("orders", range(8))
def test_no_order_of_silences_and_commands_ever_moves_an_unfit_boat(orders: int) -> None:
    """Random operator, random sea: propellers turn only in FORMATION, only while all is well."""
    rng = random.Random(orders)
    sea = Sea(leader=TURN)
    sea.settle()
    for _ in range(300):
        act = rng.randrange(8)
        if act < 3:
            anybody: list[Any] = [sea.own, sea.leader, *sea.escs]
            rng.choice(anybody).on = rng.random() < 0.7
        elif act < 6:
            sea.say(command_long(*rng.choice(ORDERS)))
        for _ in range(rng.randrange(1, 60)):
            tick = sea.step()
            seen = sea.snapshot()
            if any(tick.commands):
                assert seen["state"] == "FORMATION" and all(seen["conditions"].values())
            if seen["state"] != "FORMATION":
                assert seen["thrust_N"] == {"port": 0.0, "stbd": 0.0}
            assert_finite(seen)


# --- clocks --------------------------------------------------------------------------------------


def test_time_that_stands_still_does_no_harm() -> None:
    sea = at_sea()
    before, now_us = sea.commands, sea.ticks[-1].now_us
    for _ in range(100):
        out = sea.boat.tick(now_us)
        slots = commands(list(out.can))
        assert all(abs(a - b) <= FULL_SCALE * 0.02 for a, b in zip(slots, before, strict=True))
        assert_finite(sea.snapshot())
    assert sea.state == "FORMATION"
    sea.run(0.5)
    assert sea.state == "FORMATION"


@pytest.mark.parametrize("back_us", [1, 1_000, 10_000, 1_000_000, START_US])
def test_time_that_goes_back_is_counted_and_makes_no_jump(back_us: int) -> None:
    sea = at_sea()
    before = sea.commands
    assert sea.counter("clock_went_back") == 0
    out = sea.boat.tick(sea.ticks[-1].now_us - back_us)
    assert sea.counter("clock_went_back") == 1
    slots = commands(list(out.can))
    assert all(abs(a - b) <= FULL_SCALE * 0.1 for a, b in zip(slots, before, strict=True))
    assert_finite(sea.snapshot())
    ticks = sea.run(1.0)
    assert sea.counter("clock_went_back") == 1
    steps = [
        abs(b - a) for s, t in pairwise(ticks) for a, b in zip(s.commands, t.commands, strict=True)
    ]
    assert sea.state == "FORMATION" and max(steps) <= FULL_SCALE * 0.06


def test_a_clock_that_stays_back_does_not_keep_old_data_fresh() -> None:
    """300 ticks without a word of anybody: whatever the clock says, the propellers do not turn."""
    sea = at_sea()
    sea.now_us -= 8_000_000
    sea.own.on = sea.leader.on = False
    sea.run(3.0)
    assert not any(sea.commands), "own state and leader have been silent for 3 s"


@pytest.mark.parametrize("ahead_s", [0.1, 1.0, 3600.0, 1e8])
def test_a_late_tick_makes_no_jump_of_the_propellers(ahead_s: float) -> None:
    sea = at_sea({"THR_SLEW": 1.0})
    before = sea.commands
    out = sea.boat.tick(sea.now_us + round(ahead_s * 1e6))
    assert_finite(sea.snapshot())
    slots = commands(list(out.can))
    if ahead_s > 0.5:
        assert slots == (0, 0)
    else:
        assert all(abs(a - b) <= FULL_SCALE * 0.11 for a, b in zip(slots, before, strict=True))


@pytest.mark.parametrize("start_us", [0, 1, 2**31, 2**32 * 1000 - 5_000_000, 1_700_000_000_000_000])
def test_a_boat_may_start_at_any_time(start_us: int) -> None:
    sea = Sea(leader=Course(5.0, 5.0), own=Course(1.0, 2.0), start_us=start_us)
    sea.enter_formation()
    sea.run(10.0)
    assert sea.state == "FORMATION" and any(sea.commands)


@pytest.mark.parametrize("now_us", [-1, 2**63 - 1, 2**64 - 1, 2**64])
def test_impossible_times_raise_or_do_no_harm(now_us: int) -> None:
    sea = Sea()
    sea.settle()
    for call in (
        lambda: sea.boat.tick(now_us),
        lambda: sea.boat.on_can(0, b"\xc0", now_us),
        lambda: sea.boat.on_mavlink(b"\xfd", now_us),
    ):
        try:
            call()
        except (TypeError, ValueError, OverflowError):
            continue
    assert_finite(sea.snapshot())
    assert sea.state == "DISARMED"


@seeded(max_examples=50)
@given(st.lists(st.integers(-3_000_000, 3_000_000), min_size=1, max_size=60))
def test_no_course_of_time_gives_a_number_that_is_none(steps: list[int]) -> None:
    sea = Sea(leader=TURN)
    sea.enter_formation()
    for step in steps:
        sea.now_us = max(0, sea.now_us + step)
        tick = sea.step()
        assert all(abs(c) <= FULL_SCALE for c in tick.commands)
        assert_finite(sea.snapshot())


@pytest.mark.parametrize("seed", range(3))
def test_a_jittery_tick_sails_like_a_regular_one(seed: int) -> None:
    rng = random.Random(seed)
    regular, jittery = at_sea(), at_sea()
    for _ in range(300):
        regular.step()
        jittery.now_us += (shift := rng.randrange(-3000, 3000))
        jittery.step()
        jittery.now_us -= shift
    assert jittery.state == "FORMATION" and jittery.counter("clock_went_back") == 0
    for a, b in zip(regular.commands, jittery.commands, strict=True):
        assert abs(a - b) < FULL_SCALE * 0.02


# --- strangers -----------------------------------------------------------------------------------


@pytest.mark.parametrize("system", [STRANGER, 3, 255, 0])
def test_a_foreign_system_moves_nothing(system: int) -> None:
    """A stranger sends states, origins and clocks on the same link: not a byte on CAN changes."""
    rng = random.Random(system)
    alone, beset = Sea(leader=TURN), Sea(leader=TURN)
    strangers = [Station(system, component) for component in (1, NAVIGATION)]
    for sea in (alone, beset):
        sea.enter_formation()
    for _ in range(500):
        if beset.now_us % 50_000 == 0:
            where = Course(
                rng.uniform(-500, 500), rng.uniform(-500, 500), rng.uniform(-3, 3), 2.0, 1.0, 1.0
            )
            for stranger in strangers:
                beset.say(
                    heartbeat(),
                    origin(0, 0, 0, 0),
                    odometry(where, beset.now_us),
                    local_position(where, beset.now_us),
                    attitude(where, beset.now_us),
                    mavlink.MAVLink_timesync_message(beset.now_us * 999, beset.now_us * 1000),
                    sender=stranger,
                )
        assert alone.step().can == beset.step().can
    assert beset.state == "FORMATION"


def test_a_stranger_cannot_revive_a_silent_leader_or_navigation_unit() -> None:
    for who in ("own", "leader"):
        sea = at_sea()
        silence(sea, who)
        for _ in range(150):
            sea.say(odometry(Course(), sea.now_us), origin(), sender=Station(STRANGER, 1))
            sea.step()
        assert sea.state == "HOLD" and sea.commands == (0, 0)


def test_a_leader_that_is_the_boat_itself_is_refused() -> None:
    with pytest.raises(ValueError, match="FORM_LEADER"):
        flotilla.Boat({"MAV_SYSID": BOAT, "FORM_LEADER": BOAT})


def test_commands_to_another_boat_never_stop_or_start_this_one() -> None:
    sea = at_sea()
    for order in ((ARM, 0.0), (SET_MODE, 1.0, 4.0), (ARM, 0.0, FORCE)):
        sea.say(command_long(*order, target=(3, 1)))
        sea.run(0.2)
    assert sea.state == "FORMATION" and any(sea.commands)


# --- scalar, determinism -------------------------------------------------------------------------


@pytest.mark.parametrize(
    "parameters", [{}, {"THR_EXPO": 0.7, "THR_DEAD": 0.2}, {"LAW_KX": 1.0}], ids=str
)
def test_double_and_float_sail_alike(parameters: dict[str, float]) -> None:
    one = Sea(parameters, leader=TURN, scalar="float")
    two = Sea(parameters, leader=TURN, scalar="double")
    for sea in (one, two):
        sea.enter_formation()
        sea.run(20.0)
    assert [t.mavlink for t in one.ticks][:5] == [t.mavlink for t in two.ticks][:5]
    for a, b in zip(one.ticks, two.ticks, strict=True):
        assert all(abs(x - y) <= 4 for x, y in zip(a.commands, b.commands, strict=True))
    shown, expected = one.snapshot(), two.snapshot()
    for key in ("error", "virtual_velocity", "wrench_asked", "thrust_N"):
        assert shown[key] == pytest.approx(expected[key], rel=1e-3, abs=1e-3)


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_far_from_the_origin_float_is_as_good_as_double(scalar: str) -> None:
    """Positions are differenced before they become a small scalar."""
    near = Sea(leader=Course(5.0, 5.0, 0.5), own=Course(1.0, 2.0, 0.3))
    far = Sea(
        leader=Course(65541.0, 32773.0, 0.5), own=Course(65537.0, 32770.0, 0.3), scalar=scalar
    )
    for sea in (near, far):
        sea.enter_formation()
        sea.run(1.0)
    assert far.snapshot()["error"] == pytest.approx(near.snapshot()["error"], abs=1e-3)


def story(scalar: str) -> list[Tick]:
    sea = Sea(links=3, leader=TURN, scalar=scalar)
    sea.leader.answers_timesync = True
    rng = random.Random(11)
    sea.enter_formation()
    for k in range(1000):
        if k % 10 == 0:
            sea.boat.on_mavlink(rng.randbytes(50), sea.now_us, 1)
            sea.boat.on_can(rng.randrange(2**29), rng.randbytes(8), sea.now_us)
        if k == 500:
            sea.leader.on = False
        if k == 800:
            sea.disarm()
        sea.step()
    return sea.ticks


@pytest.mark.parametrize("scalar", ["float", "double"])
def test_the_same_input_gives_the_same_bytes(scalar: str) -> None:
    assert story(scalar) == story(scalar)


def test_boats_in_one_process_share_nothing() -> None:
    expected = story("float")
    others = [Sea({"MAV_SYSID": k, "FORM_LEADER": LEADER}) for k in (5, 6, 7)]
    for other in others:
        other.run(0.5)
    assert story("float") == expected


def test_what_a_tick_returned_stays_as_it_was() -> None:
    sea = Sea()
    out = sea.boat.tick(sea.now_us)
    kept = list(out.mavlink), list(out.can)
    for _ in range(50):
        sea.step()
    assert (list(out.mavlink), list(out.can)) == kept
    del sea
    assert (list(out.mavlink), list(out.can)) == kept


# --- fuzz ----------------------------------------------------------------------------------------


ODD = [0.0, 1e-38, 1e3, -1e6, 3e38]


def frame(kind: Any, payload: bytes, system: int, component: int) -> bytes:
    """A frame with a right checksum, whatever is in it."""
    body = (
        bytes([len(payload), 0, 0, 0, system, component]) + kind.id.to_bytes(3, "little") + payload
    )
    checksum = mavlink.x25crc(body + bytes([kind.crc_extra])).crc
    return bytes(b"\xfd" + body + checksum.to_bytes(2, "little"))


def recognisable(rng: random.Random) -> bytes:
    """A message with a right checksum and random content, of any length, or a frame cut short."""
    kind = mavlink.mavlink_map.get(
        rng.choice([0, 11, 20, 23, 30, 32, 33, 49, 75, 76, 111, 253, 331, -1])
    )
    if kind is None:
        return b"\xfd" + rng.randbytes(rng.randrange(300))
    payload = rng.randbytes(rng.choice([kind.unpacker.size, rng.randrange(1, 256)]))
    return frame(kind, payload, rng.choice([BOAT, LEADER, STRANGER]), rng.randrange(256))


def test_twenty_thousand_random_chunks_of_mavlink_never_move_a_boat() -> None:
    rng = random.Random(2718)
    boat = flotilla.Boat({"MAV_SYSID": BOAT, "FORM_LEADER": LEADER}, 2)
    now_us = START_US
    for k in range(20_000):
        data = rng.randbytes(rng.randrange(80)) if k % 2 else recognisable(rng)
        boat.on_mavlink(data, now_us, k // 2 % 2)
        if k % 10 == 0:
            now_us += 10_000
            out = boat.tick(now_us)
            assert boat.state == "DISARMED" and not any(commands(list(out.can)))
    assert_finite(boat.snapshot())
    counters = boat.snapshot()["counters"]
    assert counters["mavlink_received"] > 1000 and counters["mavlink_bad_value"] > 100


def test_thirty_thousand_random_frames_never_move_a_boat() -> None:
    rng = random.Random(3141)
    sea = Sea()
    sea.escs[0].on = sea.escs[1].on = False
    known = [ESC_STATUS << 8, NODE_STATUS << 8, 0x180, 1 << 16 | 1 << 15 | 20 << 8 | 0x80]
    for k in range(30_000):
        can_id = (
            rng.randrange(2**29) if k % 2 else rng.choice(known) | rng.randrange(128) | 16 << 24
        )
        sea.boat.on_can(can_id, rng.randbytes(rng.randrange(9)), sea.now_us)
        if k % 15 == 0:
            tick = sea.step()
            assert sea.state == "DISARMED" and tick.commands == (0, 0)
    assert sea.counter("can_bad_frame") + sea.counter("can_bad_checksum") > 1000


def test_random_payloads_of_own_and_leader_never_give_a_number_that_is_none() -> None:
    """Armed, states of random bits with right checksums: it stops, or stays within limits."""
    rng = random.Random(1618)
    sea = at_sea()
    sea.own.on = sea.leader.on = False
    for _ in range(5000):
        kind = mavlink.mavlink_map[rng.choice([30, 32, 49, 331, 111])]
        whose = rng.choice([sea.own, sea.leader]).station
        if rng.random() < 0.5:
            payload = rng.randbytes(kind.unpacker.size)
        else:  # all well but one field
            kind = mavlink.MAVLink_odometry_message
            message = odometry(Course(), sea.now_us)
            name = rng.choice(["x", "y", "z", "vx", "vy", "vz", "yawspeed"])
            setattr(message, name, rng.choice(ODD))
            payload = bytes(message.pack(whose.encoder))[10:-2]
        sea.boat.on_mavlink(frame(kind, payload, whose.system, whose.component), sea.now_us)
        tick = sea.step()
        assert all(abs(c) <= FULL_SCALE for c in tick.commands)
        assert_finite(sea.snapshot())
