# SPDX-License-Identifier: MIT
"""Other nodes on the boat's bus: a second controller, and ESCs that request a node id."""

import dronecan
import pytest
from dronecan.transport import Transfer

from tests.target.bus import NODE, Frames, reference, to_wire, transfers, type_of
from tests.target.sea import Sea, acks, at_sea, texts

STRANGER = 42
ALLOCATION = 1


def raw_command(node: int, *values: int) -> Frames:
    payload = dronecan.uavcan.equipment.esc.RawCommand(cmd=list(values))
    return to_wire(Transfer(0, node, payload=payload, transfer_priority=7))


def rpm_command(node: int, *values: int) -> Frames:
    payload = dronecan.uavcan.equipment.esc.RPMCommand(rpm=list(values))
    return to_wire(Transfer(0, node, payload=payload, transfer_priority=7))


def arming_status(node: int, status: int) -> Frames:
    payload = dronecan.uavcan.equipment.safety.ArmingStatus(status=status)
    return to_wire(Transfer(0, node, payload=payload, transfer_priority=24))


FOREIGN = {
    "RawCommand": raw_command(STRANGER, 100, 100),
    "RawCommand of zeros": raw_command(STRANGER, 0, 0),
    "RPMCommand": rpm_command(STRANGER, 1500, -1500),
    "ArmingStatus": arming_status(STRANGER, 255),
    "RawCommand under our own id": raw_command(NODE, 100, 100),
}


@pytest.mark.parametrize("kind", FOREIGN)
def test_a_boat_does_not_arm_beside_another_controller_until_that_is_gone(
    sea: Sea, kind: str
) -> None:
    sea.settle()
    sea.on_can(FOREIGN[kind])
    tick = sea.arm()
    assert acks(tick) == [(400, 1)]
    assert texts([tick]) == ["PreArm: another controller on the CAN bus"]
    sea.run(2.1)
    sea.enter_hold()


@pytest.mark.parametrize("kind", FOREIGN)
def test_another_controller_under_way_is_a_fault_at_once(kind: str) -> None:
    sea = at_sea()
    sea.on_can(FOREIGN[kind])
    tick = sea.step()
    assert sea.state == "FAULT" and tick.commands == (0, 0) and tick.arming == [0]


def allocations(frames: Frames) -> list[tuple[int, bytes]]:
    mine = [f for f in frames if type_of(f[0]) == (False, ALLOCATION, NODE)]
    return [(t.payload.node_id, bytes(t.payload.unique_id)) for t in transfers(mine)]


def spec_log() -> tuple[list[tuple[int, bytes]], bytes]:
    """The requests in the specification's log, and the unique id that they contain."""
    case = next(c for c in reference("generated") if c["name"] == "spec DNA log")
    frames = [frame.split("#") for frame in case["frames"]]
    asked = [(int(i, 16), bytes.fromhex(d)) for i, d in frames if int(i, 16) & 0x7F == 0]
    return asked, bytes.fromhex(case["values"]["unique_id"])


def test_the_node_of_the_specifications_log_gets_its_id_and_keeps_it(sea: Sea) -> None:
    asked, unique_id = spec_log()
    for _ in range(2):
        answers = []
        for request in asked:
            sea.on_can([request])
            answers += allocations(sea.step().can)
        assert answers == [(0, unique_id[:6]), (0, unique_id[:12]), (125, unique_id)]


def test_ids_that_are_taken_are_not_given_away(sea: Sea) -> None:
    sea.escs[0].node = 125
    sea.settle()
    asked, unique_id = spec_log()
    for request in asked:
        sea.on_can([request])
        last = allocations(sea.step().can)
    assert last == [(124, unique_id)]


def test_a_request_that_comes_too_late_or_out_of_turn_is_not_answered(sea: Sea) -> None:
    asked, _ = spec_log()
    sea.on_can([asked[1]])
    assert not allocations(sea.step().can)
    sea.on_can([asked[0]])
    assert allocations(sea.step().can)
    sea.run(0.6)
    sea.on_can([asked[1]])
    assert not allocations(sea.step().can)
