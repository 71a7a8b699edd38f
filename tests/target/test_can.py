# SPDX-License-Identifier: MIT
"""The boat's DroneCAN against PyPI dronecan: what it sends, understands and survives."""

from __future__ import annotations

import json
import random
from itertools import pairwise
from pathlib import Path
from typing import Any

import dronecan
import pytest
from dronecan.transport import Transfer, TransferError
from hypothesis import given
from hypothesis import strategies as st

from tests.target.harness import (
    ARMING_STATUS,
    ESC_STATUS,
    FORMATION,
    FULL_SCALE,
    GET_NODE_INFO,
    HOLD,
    NODE_STATUS,
    RAW_COMMAND,
    Course,
    Frames,
    Sea,
    Tick,
    arming_statuses,
    commands,
    esc_status,
    node_info_request,
    node_status,
    seeded,
    transfers,
    type_of,
)

NODE, TOOL = 20, 100
VECTORS = Path(__file__).parents[1] / "reference" / "dronecan_vectors.json"
IDS = st.integers(0, 2**29 - 1)


def of_type(ticks: list[Tick], type_id: int, service: bool = False) -> list[Transfer]:
    frames = [f for tick in ticks for f in tick.can if type_of(f[0])[:2] == (service, type_id)]
    return transfers(frames)


def refused(sea: Sea) -> int:
    return sum(sea.counter(name) for name in ("can_bad_frame", "can_bad_checksum", "can_bad_value"))


def hear(sea: Sea, frames: Frames) -> None:
    for can_id, data in frames:
        sea.boat.on_can(can_id, data, sea.now_us)


# --- what the boat sends -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def session() -> Sea:
    """Two minutes with arming, sailing, a fault and node info requests."""
    sea = Sea(leader=Course(15.0, -9.0, 0.5, 0.4, 0.0, 0.1))
    sea.settle()
    for k in range(6):
        sea.arm()
        sea.run(1.0)
        sea.mode(FORMATION)
        sea.run(10.0)
        sea.escs[k % 2].on = k % 3 == 0
        for n in range(3):
            hear(sea, node_info_request(TOOL, NODE, (7 * k + n) % 32))
            sea.step()
        sea.run(2.0)
        sea.escs[k % 2].on = True
        sea.disarm()
        sea.run(5.0)
    return sea


def test_dronecan_decodes_every_frame_that_a_boat_sends(session: Sea) -> None:
    frames = [f for tick in session.ticks for f in tick.can]
    found = transfers(frames)
    kinds = {dronecan.get_dronecan_data_type(t.payload).full_name for t in found}
    assert kinds == {
        "uavcan.equipment.esc.RawCommand",
        "uavcan.equipment.safety.ArmingStatus",
        "uavcan.protocol.NodeStatus",
        "uavcan.protocol.GetNodeInfo",
    }
    single = [t for t in found if not t.service_not_message]
    answers = [t for t in found if t.service_not_message]
    assert len(frames) - len(single) > 2 * len(answers) > 0, "answers are of several frames"


def test_ids_are_extended_and_come_from_the_boats_node(session: Sea) -> None:
    for tick in session.ticks:
        for can_id, data in tick.can:
            assert 0 <= can_id < 2**29 and 1 <= len(data) <= 8
            assert type_of(can_id)[2] == NODE


def test_ids_are_those_of_the_reference(session: Sea) -> None:
    """Captured from another implementation, for the same types and priorities but node 10."""
    captured = json.loads(VECTORS.read_text())["captured"]
    reference = {
        v["name"]: int(v["can_id"], 16) & 0xFFFF00 for v in captured if not v["id"]["service"]
    }
    sent = {
        can_id & 0xFFFF00 for tick in session.ticks for can_id, _ in tick.can if not can_id & 0x80
    }
    assert sent == {t << 8 for t in (RAW_COMMAND, ARMING_STATUS, NODE_STATUS)}
    assert sent <= set(reference.values())


def test_a_command_is_more_urgent_than_anything_else(session: Sea) -> None:
    priority = {type_of(i)[:2]: i >> 24 for tick in session.ticks for i, _ in tick.can}
    assert all(priority[False, RAW_COMMAND] <= other for other in priority.values())


def test_transfer_ids_count_by_one_for_each_type(session: Sea) -> None:
    for type_id in (RAW_COMMAND, ARMING_STATUS, NODE_STATUS):
        ids = [t.transfer_id for t in of_type(session.ticks, type_id)]
        assert ids == [(ids[0] + k) % 32 for k in range(len(ids))]


def test_both_propellers_are_commanded_in_every_tick(session: Sea) -> None:
    for tick in session.ticks:
        assert sum(type_of(i)[:2] == (False, RAW_COMMAND) for i, _ in tick.can) == 1
        assert len(tick.commands) == 2
        assert all(-FULL_SCALE <= c <= FULL_SCALE for c in tick.commands)
    assert any(tick.commands != (0, 0) for tick in session.ticks)


def test_arming_status_comes_ten_times_a_second(session: Sea) -> None:
    times = [tick.now_us for tick in session.ticks if arming_statuses(tick.can)]
    gaps = [b - a for a, b in pairwise(times)]
    assert max(gaps) <= 100_000
    assert len(times) == pytest.approx((times[-1] - times[0]) / 1e5, rel=0.05)
    assert {s for tick in session.ticks for s in arming_statuses(tick.can)} == {0, 255}


def test_node_status_comes_once_a_second_with_uptime_and_health() -> None:
    sea = Sea()
    sea.run(30.0)
    beats = of_type(sea.ticks, NODE_STATUS)
    assert len(beats) == 30
    uptimes = [t.payload.uptime_sec for t in beats]
    assert uptimes == list(range(uptimes[0], uptimes[0] + 30))
    assert all((t.payload.health, t.payload.mode) == (0, 0) for t in beats)


def test_uptime_counts_from_the_first_tick() -> None:
    sea = Sea(start_us=10**15)
    sea.run(3.0)
    assert [t.payload.uptime_sec for t in of_type(sea.ticks, NODE_STATUS)] == [0, 1, 2]


@pytest.mark.parametrize("node", [1, 42, 125])
def test_the_node_id_is_can_node(node: int) -> None:
    sea = Sea({"CAN_NODE": node})
    sea.settle()
    hear(sea, node_info_request(TOOL, node))
    ticks = sea.run(1.0)
    assert {type_of(i)[2] for tick in ticks for i, _ in tick.can} == {node}
    assert len(of_type(ticks, GET_NODE_INFO, service=True)) == 1


@pytest.mark.parametrize("transfer_id", [0, 1, 30, 31])
@pytest.mark.parametrize("asker", [1, TOOL, 127])
def test_get_node_info_is_answered_in_several_frames_to_the_asker(
    transfer_id: int, asker: int
) -> None:
    sea = Sea()
    sea.run(3.0)
    hear(sea, node_info_request(asker, NODE, transfer_id))
    ticks = sea.run(0.5)
    frames = [f for tick in ticks for f in tick.can if f[0] & 0x80]
    assert len(frames) > 1
    sent_in = [tick for tick in ticks if any(i & 0x80 for i, _ in tick.can)]
    assert len(sent_in) == 1, "the frames of one transfer are sent back to back"
    (answer,) = transfers(frames)
    assert (answer.source_node_id, answer.dest_node_id) == (NODE, asker)
    assert answer.transfer_id == transfer_id and not answer.request_not_response
    info = answer.payload
    assert "flotilla" in str(info.name).lower()
    assert info.status.uptime_sec in (2, 3) and (info.status.health, info.status.mode) == (0, 0)
    assert (
        any(info.hardware_version.unique_id)
        or info.software_version.major + info.software_version.minor > 0
    )


def test_every_request_is_answered_once() -> None:
    sea = Sea()
    sea.settle()
    for transfer_id in range(40):
        hear(sea, node_info_request(TOOL, NODE, transfer_id % 32))
        answers = of_type(sea.run(0.05), GET_NODE_INFO, service=True)
        assert [t.transfer_id for t in answers] == [transfer_id % 32]


def test_a_request_to_another_node_is_not_answered() -> None:
    sea = Sea()
    for node in (1, NODE - 1, NODE + 1, 127):
        hear(sea, node_info_request(TOOL, node))
        assert not of_type(sea.run(0.2), GET_NODE_INFO, service=True)


def test_a_flood_of_requests_does_not_stop_the_commands() -> None:
    sea = Sea()
    sea.enter_formation()
    for k in range(200):
        for n in range(50):
            hear(
                sea,
                node_info_request(
                    1 + (k + n) % 127 if (k + n) % 127 + 1 != NODE else 99, NODE, n % 32
                ),
            )
        assert len(sea.step().commands) == 2
        transfers(sea.ticks[-1].can)
    assert sea.state == "FORMATION"


# --- indices, directions, limits -----------------------------------------------------------------

FAR_AHEAD = Course(500.0, 0.0, 0.0)
FAR_ASTERN = Course(-500.0, 0.0, 0.0)


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
    sea = sail(parameters, Course(6.0, 0.0, 1.0))
    reference = sail({}, Course(6.0, 0.0, 1.0))
    assert len(sea.commands) > max(port, stbd)
    assert (sea.commands[port], sea.commands[stbd]) == reference.commands != (0, 0)
    assert reference.commands[0] != reference.commands[1]
    assert not any(c for k, c in enumerate(sea.commands) if k not in (port, stbd))
    frames = [f for f in sea.ticks[-1].can if type_of(f[0])[:2] == (False, RAW_COMMAND)]
    assert (len(frames) > 1) == (max(port, stbd) > 3)
    sea.disarm()
    assert sea.state == "DISARMED" and not any(sea.commands)


@pytest.mark.parametrize(("port", "stbd"), [(1, 1), (-1, 1), (1, -1), (-1, -1)])
def test_a_propeller_that_turns_the_other_way_gets_the_opposite_command(
    port: int, stbd: int
) -> None:
    plain = sail({}, Course(6.0, 0.0, 1.0))
    turned = sail({"THR_PORT_DIR": port, "THR_STBD_DIR": stbd}, Course(6.0, 0.0, 1.0))
    for a, b in zip(plain.ticks, turned.ticks, strict=True):
        assert b.commands == (port * a.commands[0], stbd * a.commands[1])
    assert plain.commands != (0, 0)


@pytest.mark.parametrize(("leader", "full"), [(FAR_AHEAD, FULL_SCALE), (FAR_ASTERN, -FULL_SCALE)])
@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize("expo", [0.0, 0.5, 1.0])
def test_full_thrust_is_8191_either_way(
    leader: Course, full: int, direction: int, expo: float
) -> None:
    sea = sail({"THR_PORT_DIR": direction, "THR_STBD_DIR": direction, "THR_EXPO": expo}, leader)
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
    sea = Sea({"THR_SLEW": 1.0}, own=Course(), leader=FAR_AHEAD)
    sea.enter_formation()
    first = len(sea.ticks)
    sea.run(2.0)
    speeds = [t.commands[0] for t in sea.ticks[first:]]
    steps = [b - a for a, b in pairwise(speeds)]
    assert max(steps) <= FULL_SCALE * 0.01 + 1 and speeds[-1] == FULL_SCALE
    sea.disarm()
    assert sea.commands == (0, 0)


def test_without_slew_limit_full_thrust_comes_at_once() -> None:
    sea = Sea({"THR_SLEW": 0.0}, own=Course(), leader=FAR_AHEAD)
    sea.enter_hold()
    assert sea.mode(FORMATION).commands == (FULL_SCALE, FULL_SCALE)


def test_a_thrust_within_the_dead_band_is_exactly_zero() -> None:
    sea = sail(
        {"THR_DEAD": 15.0, "THR_FWD_MAX": 100.0, "THR_REV_MAX": 100.0}, Course(0.5, 0.0, 0.0)
    )
    assert sea.snapshot()["wrench_asked"]["X_N"] != 0.0
    assert sea.commands == (0, 0)


# --- disarmed is zero ----------------------------------------------------------------------------


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
    for tick in quiet:
        for can_id, data in tick.can:
            single = data[-1] & 0xC0 == 0xC0
            if type_of(can_id)[:2] == (False, RAW_COMMAND) and single:
                assert not any(data[:-1])


def test_arming_status_changes_in_the_tick_of_the_order() -> None:
    sea = Sea()
    sea.settle()
    for k in range(10):
        sea.run(0.01 * k)
        assert arming_statuses(sea.arm().can)[-1] == 255
        sea.run(0.01 * k)
        assert arming_statuses(sea.disarm().can)[-1] == 0


def test_arming_status_is_255_exactly_while_armed(session: Sea) -> None:
    state = 0
    for tick in session.ticks:
        for m in tick.named("HEARTBEAT"):
            state = 255 if m.base_mode & 128 else 0
        for status in arming_statuses(tick.can):
            assert status == state
        if any(tick.commands):
            assert state == 255


def test_a_refused_arming_never_says_255() -> None:
    sea = Sea()
    sea.escs[0].on = False
    sea.run(2.0)
    for _ in range(20):
        sea.arm()
        sea.run(0.07)
    assert {s for tick in sea.ticks for s in arming_statuses(tick.can)} == {0}


# --- ESCs ----------------------------------------------------------------------------------------


def offline_after(sea: Sea) -> float:
    """Seconds from now until the boat takes its ESCs to be offline."""
    began_us = sea.now_us
    for _ in range(1000):
        sea.step()
        if not sea.condition("escs_online"):
            return (sea.ticks[-1].now_us - began_us) * 1e-6
    raise AssertionError("still online after 10 s")


def test_escs_are_online_once_both_report_and_are_healthy() -> None:
    sea = Sea()
    assert not sea.condition("escs_online")
    sea.step()
    assert sea.condition("escs_online")


@pytest.mark.parametrize("silent", [[0], [1], [0, 1]], ids=["port", "stbd", "both"])
@pytest.mark.parametrize("limit", [0.3, 1.2, 2.5])
def test_an_esc_is_offline_fs_esc_s_after_its_last_status(silent: list[int], limit: float) -> None:
    sea = Sea({"FS_ESC_S": limit})
    sea.run(1.0)
    while sea.now_us % 100_000:
        sea.step()
    sea.step()  # both have just said their status
    last_us = sea.ticks[-1].now_us
    for k in silent:
        sea.escs[k].on = False
    for _ in range(600):
        for k in silent:  # its node lives on, only its status is missing
            if (sea.now_us - last_us) % 500_000 == 0:
                hear(
                    sea,
                    node_status(sea.escs[k].node, sea.now_us // 10**6, sea.now_us // 500_000 % 32),
                )
        sea.step()
        age = (sea.ticks[-1].now_us - last_us) * 1e-6
        if age < limit - 0.011:
            assert sea.condition("escs_online"), age
        if age > limit + 0.011:
            assert not sea.condition("escs_online"), age


def test_an_esc_is_offline_three_seconds_after_its_last_node_status() -> None:
    sea = Sea()
    sea.run(1.5)
    sea.escs[1].next_beat_us = 2**62
    waited = offline_after(sea)
    assert 2.0 <= waited <= 3.01
    sea.escs[1].next_beat_us = 0
    sea.run(0.02)
    assert sea.condition("escs_online")


@pytest.mark.parametrize("health", [1, 2, 3])
@pytest.mark.parametrize("which", [0, 1])
def test_an_esc_whose_node_is_not_well_is_not_online(health: int, which: int) -> None:
    sea = Sea()
    sea.escs[which].health = health
    sea.run(1.5)
    assert not sea.condition("escs_online")
    sea.escs[which].health = 0
    sea.run(1.1)
    assert sea.condition("escs_online")


def test_an_esc_that_becomes_ill_under_way_is_a_fault(sailing: Sea) -> None:
    sailing.run(0.5)
    sailing.escs[0].health = 2
    sailing.run(1.1)
    assert sailing.state == "FAULT" and sailing.commands == (0, 0)


def test_other_escs_and_other_nodes_do_not_count() -> None:
    sea = Sea()
    for esc in sea.escs:
        esc.index += 2
    sea.run(2.0)
    assert not sea.condition("escs_online")
    hear(sea, esc_status(31, 0))
    hear(sea, esc_status(32, 1))
    sea.step()
    assert sea.condition("escs_online")


def test_one_node_may_drive_both_propellers() -> None:
    sea = Sea()
    sea.escs[0].on = sea.escs[1].on = False
    for k in range(30):
        hear(sea, esc_status(40, 0, 2 * k % 32) + esc_status(40, 1, (2 * k + 1) % 32))
        hear(sea, node_status(40, k, k % 32))
        sea.run(0.1)
    assert sea.condition("escs_online")


def test_the_frames_of_two_escs_may_interleave() -> None:
    sea = Sea()
    sea.escs[0].on = sea.escs[1].on = False
    port, stbd = esc_status(31, 0), esc_status(32, 1)
    hear(sea, node_status(31, 1) + node_status(32, 1))
    hear(sea, [frame for pair in zip(port, stbd, strict=True) for frame in pair])
    sea.step()
    assert sea.condition("escs_online") and refused(sea) == 0


@pytest.mark.parametrize(
    "changes",
    [
        {"voltage": v, "current": v, "temperature": v}
        for v in (float("nan"), float("inf"), -float("inf"), 65504.0)
    ],
    ids=str,
)
def test_an_esc_may_not_know_its_volts_and_amperes(changes: dict[str, Any]) -> None:
    sea = Sea()
    sea.escs[0].on = sea.escs[1].on = False
    hear(sea, node_status(31, 1) + node_status(32, 1))
    hear(sea, esc_status(31, 0, **changes) + esc_status(32, 1, rpm=-131072, error_count=2**32 - 1))
    sea.step()
    assert sea.condition("escs_online")


# --- damage --------------------------------------------------------------------------------------


def after(frames: Frames, sea: Sea | None = None) -> Sea:
    """A sea where these frames are the only status of the starboard ESC; all else is well."""
    sea = sea or Sea()
    sea.escs[1].on = False
    hear(sea, node_status(32, 1))
    hear(sea, frames)
    sea.step()
    return sea


GOOD = esc_status(32, 1, 3)


def test_the_good_status_counts() -> None:
    assert after(GOOD).condition("escs_online")


@pytest.mark.parametrize("byte", range(sum(len(d) for _, d in GOOD)))
def test_a_status_with_one_wrong_bit_does_not_count(byte: int) -> None:
    rng = random.Random(byte)
    flat = [(n, k) for n, (_, data) in enumerate(GOOD) for k in range(len(data))]
    frame, at = flat[byte]
    damaged = list(GOOD)
    data = bytearray(damaged[frame][1])
    data[at] ^= 1 << rng.randrange(8)
    damaged[frame] = (damaged[frame][0], bytes(data))
    sea = after(damaged)
    assert not sea.condition("escs_online")
    hear(sea, esc_status(32, 1, 4))
    sea.step()
    assert sea.condition("escs_online"), "the next good one counts"


@pytest.mark.parametrize("missing", range(3))
def test_a_status_with_a_lost_frame_does_not_count(missing: int) -> None:
    sea = after([f for k, f in enumerate(GOOD) if k != missing])
    assert not sea.condition("escs_online")
    hear(sea, esc_status(32, 1, 4))
    sea.step()
    assert sea.condition("escs_online")


@pytest.mark.parametrize("order", [(0, 2, 1), (1, 0, 2), (2, 1, 0)])
def test_a_status_out_of_order_does_not_count(order: tuple[int, ...]) -> None:
    assert not after([GOOD[k] for k in order]).condition("escs_online")


def test_a_damaged_status_is_counted() -> None:
    damaged = list(GOOD)
    damaged[1] = (damaged[1][0], b"\x00" + damaged[1][1][1:])
    assert after(damaged).counter("can_bad_checksum") == 1
    assert after(GOOD[1:]).counter("can_bad_frame") >= 1


def reference(kind: str) -> list[Any]:
    return list(json.loads(VECTORS.read_text())[kind])


@pytest.mark.parametrize("vector", reference("damaged"), ids=lambda v: v["name"])
def test_damaged_sequences_of_the_reference_deliver_what_they_should(
    vector: dict[str, Any],
) -> None:
    """Node 21 of the vectors reports index 0; it counts exactly if a transfer is delivered."""
    assert int(vector["can_id"], 16) >> 8 & 0xFFFF == ESC_STATUS
    sea = Sea()
    sea.escs[0].on = False
    hear(sea, node_status(21, 1))
    hear(sea, [(int(vector["can_id"], 16), bytes.fromhex(data)) for data in vector["frames"]])
    sea.step()
    assert sea.condition("escs_online") == (vector["transfers_delivered"] > 0)


def test_the_whole_reference_is_survived() -> None:
    sea = Sea()
    for kind in ("captured", "generated", "damaged"):
        for vector in reference(kind):
            for text in vector["frames"]:  # either DATA or ID#DATA
                can_id, _, data = text.rpartition("#")
                sea.boat.on_can(
                    int(can_id or vector["can_id"], 16), bytes.fromhex(data), sea.now_us
                )
            sea.step()
    assert sea.state == "DISARMED"
    assert sea.counter("can_received") > 0


def test_a_frame_without_tail_byte_is_counted() -> None:
    sea = Sea()
    for type_id in (ESC_STATUS, NODE_STATUS):
        sea.boat.on_can(16 << 24 | type_id << 8 | 32, b"", sea.now_us)
    assert sea.counter("can_bad_frame") == 2


@pytest.mark.parametrize("size", [9, 12, 64, 1000])
def test_more_than_eight_bytes_are_refused_or_counted(size: int) -> None:
    sea = Sea()
    try:
        sea.boat.on_can(16 << 24 | ESC_STATUS << 8 | 32, b"\xc0" * size, sea.now_us)
    except ValueError:
        return
    assert refused(sea) == 1


@seeded(max_examples=300)
@given(st.lists(st.tuples(IDS, st.binary(max_size=8)), max_size=30))
def test_random_frames_never_upset_a_boat(frames: Frames) -> None:
    sea = Sea()
    hear(sea, frames)
    tick = sea.step()
    assert sea.state == "DISARMED" and tick.commands == (0, 0)
    transfers(tick.can)


RELATED = st.sampled_from(
    [
        t << 8 | n
        for t in (ESC_STATUS, NODE_STATUS, RAW_COMMAND, ARMING_STATUS, 1)
        for n in (0, 31, 32, NODE, 127)
    ]
    + [
        GET_NODE_INFO << 16 | 1 << 15 | NODE << 8 | 0x80 | TOOL,
        GET_NODE_INFO << 16 | NODE << 8 | 0x80 | TOOL,
    ]
)


@seeded(max_examples=300)
@given(st.lists(st.tuples(RELATED, st.binary(max_size=7), st.integers(0, 255)), max_size=40))
def test_random_frames_of_the_types_it_reads_never_upset_a_boat(
    raw: list[tuple[int, bytes, int]],
) -> None:
    sea = Sea()
    hear(sea, [(16 << 24 | can_id, data + bytes([tail])) for can_id, data, tail in raw])
    tick = sea.step()
    assert sea.state == "DISARMED" and tick.commands == (0, 0)
    transfers(tick.can)


@pytest.mark.parametrize("seed", range(3))
def test_a_sailing_boat_keeps_its_escs_among_random_frames(seed: int) -> None:
    rng = random.Random(seed)
    sea = Sea()
    sea.enter_formation()
    busy = {31, 32}
    for _ in range(500):
        for _ in range(5):
            can_id = rng.randrange(2**29)
            kind = type_of(can_id)
            if kind[2] in busy or kind[:2] in ((False, RAW_COMMAND), (False, ARMING_STATUS)):
                continue
            sea.boat.on_can(can_id, rng.randbytes(rng.randrange(9)), sea.now_us)
        sea.step()
    assert sea.state == "FORMATION"


def test_the_oracle_refuses_a_damaged_command() -> None:
    """The oracle's own check: dronecan sees a wrong transfer CRC."""
    sea = Sea({"ESC_STBD": 19})
    frames = [f for f in sea.step().can if type_of(f[0])[:2] == (False, RAW_COMMAND)]
    assert not any(commands(frames)) and len(commands(frames)) == 20
    frames[1] = (frames[1][0], b"\x01" + frames[1][1][1:])
    with pytest.raises(TransferError):
        commands(frames)
