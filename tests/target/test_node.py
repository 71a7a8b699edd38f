# SPDX-License-Identifier: MIT
"""The boat as a DroneCAN node: frames, ids, status and node info."""

from __future__ import annotations

import dronecan
import pytest
from dronecan.transport import Transfer

from tests.target.bus import (
    ARMING_STATUS,
    GET_NODE_INFO,
    NODE,
    NODE_STATUS,
    RAW_COMMAND,
    TOOL,
    node_info_request,
    of_type,
    reference,
    transfers,
    type_of,
)
from tests.target.sea import Sea, Tick
from tests.turns import some


def sent(ticks: list[Tick], type_id: int, service: bool = False) -> list[Transfer]:
    return transfers(of_type([f for tick in ticks for f in tick.can], type_id, service))


def test_dronecan_decodes_every_frame_that_a_boat_sends(outing: Sea) -> None:
    frames = [f for tick in outing.ticks for f in tick.can]
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


def test_ids_are_extended_and_come_from_the_boats_node(outing: Sea) -> None:
    for can_id, data in some(frame for tick in outing.ticks for frame in tick.can):
        assert 0 <= can_id < 2**29 and 1 <= len(data) <= 8
        assert type_of(can_id)[2] == NODE


def test_ids_are_those_of_the_reference(outing: Sea) -> None:
    """Captured from another implementation, with the same types and priorities, but as node 10."""
    captured = [v for v in reference("captured") if not v["id"]["service"]]
    ours = {i & 0xFFFF00 for tick in outing.ticks for i, _ in tick.can if not i & 0x80}
    assert ours == {t << 8 for t in (RAW_COMMAND, ARMING_STATUS, NODE_STATUS)}
    assert ours <= {int(v["can_id"], 16) & 0xFFFF00 for v in captured}


def test_a_command_is_more_urgent_than_anything_else(outing: Sea) -> None:
    priority = {type_of(i)[:2]: i >> 24 for tick in outing.ticks for i, _ in tick.can}
    assert len(priority) > 3
    assert all(priority[False, RAW_COMMAND] <= other for other in priority.values())


def test_transfer_ids_count_by_one_for_each_type(outing: Sea) -> None:
    for type_id in (RAW_COMMAND, ARMING_STATUS, NODE_STATUS):
        ids = [t.transfer_id for t in sent(outing.ticks, type_id)]
        assert ids == [(ids[0] + k) % 32 for k in range(len(ids))]


def test_node_status_comes_once_a_second_with_uptime_and_health(sea: Sea) -> None:
    sea.run(30.0)
    beats = sent(sea.ticks, NODE_STATUS)
    assert len(beats) == 30
    uptimes = [t.payload.uptime_sec for t in beats]
    assert uptimes == list(range(uptimes[0], uptimes[0] + 30))
    assert all((t.payload.health, t.payload.mode) == (0, 0) for t in beats)


def test_uptime_counts_from_the_first_tick() -> None:
    sea = Sea(start_us=10**15)
    sea.run(3.0)
    assert [t.payload.uptime_sec for t in sent(sea.ticks, NODE_STATUS)] == [0, 1, 2]


@pytest.mark.parametrize("node", [1, 42, 125])
def test_the_node_id_is_can_node(node: int) -> None:
    sea = Sea({"CAN_NODE": node})
    sea.settle()
    sea.on_can(node_info_request(TOOL, node))
    ticks = sea.run(1.0)
    assert {type_of(i)[2] for tick in ticks for i, _ in tick.can} == {node}
    assert len(sent(ticks, GET_NODE_INFO, service=True)) == 1


@pytest.mark.parametrize("transfer_id", [0, 1, 30, 31])
@pytest.mark.parametrize("asker", [1, TOOL, 127])
def test_get_node_info_is_answered_in_several_frames_to_the_asker(
    sea: Sea, transfer_id: int, asker: int
) -> None:
    sea.run(3.0)
    sea.on_can(node_info_request(asker, NODE, transfer_id))
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
    software = info.software_version
    assert any(info.hardware_version.unique_id) or software.major + software.minor > 0


def test_every_request_is_answered_once(sea: Sea) -> None:
    sea.settle()
    for transfer_id in range(40):
        sea.on_can(node_info_request(TOOL, NODE, transfer_id % 32))
        answers = sent(sea.run(0.05), GET_NODE_INFO, service=True)
        assert [t.transfer_id for t in answers] == [transfer_id % 32]


def test_a_request_to_another_node_is_not_answered(sea: Sea) -> None:
    for node in (1, NODE - 1, NODE + 1, 127):
        sea.on_can(node_info_request(TOOL, node))
        assert not sent(sea.run(0.2), GET_NODE_INFO, service=True)


def test_a_flood_of_requests_does_not_stop_the_commands(sea: Sea) -> None:
    sea.enter_formation()
    for k in range(200):
        for n in range(50):
            asker = 1 + (k + n) % 127
            sea.on_can(node_info_request(99 if asker == NODE else asker, NODE, n % 32))
        assert len(sea.step().commands) == 2
        transfers(sea.ticks[-1].can)
    assert sea.state == "FORMATION"
