# SPDX-License-Identifier: MIT
"""Checks the nodes on the CAN bus: two healthy motor controllers, each with its own index."""

import time
from collections import Counter, defaultdict
from collections.abc import Iterator

import can

from sil.doctor.boat_file import Boat
from sil.doctor.finding import Finding, bad, doubt, ok
from sil.wire.dronecan import (
    ARMING_STATUS,
    ESC_STATUS,
    NODE_STATUS,
    RAW_COMMAND,
    EscStatus,
    NodeStatus,
)
from sil.wire.dronecan_transfer import FrameId, Kind, Receiver, message_subject

_HEARD = (NODE_STATUS, ESC_STATUS, RAW_COMMAND, ARMING_STATUS)
_HEALTH = ("OK", "WARNING", "ERROR", "CRITICAL")
_ALLOCATION = 1  # data type of dynamic node id allocation, as it appears in an anonymous frame
_POWER = "check their supply, CAN-H and CAN-L, and 120 Ω at both ends of the bus"


class Nodes:
    """The nodes heard: by node id, or by the index of a motor controller."""

    def __init__(self) -> None:
        self.frames = 0
        self.nameless = 0
        self.status: dict[int, NodeStatus] = {}
        self.restarts: Counter[int] = Counter()
        self.escs: dict[int, set[int]] = defaultdict(set)
        self.commanders: set[int] = set()
        self._receiver = Receiver({message_subject(kind): kind for kind in _HEARD})

    def hear(self, message: can.Message, now_us: int) -> None:
        """Process a frame; frames of other protocols are only counted."""
        self.frames += 1
        if not message.is_extended_id or message.is_error_frame or message.is_remote_frame:
            return
        frame = FrameId.unpack(message.arbitration_id)
        if frame.kind is Kind.ANONYMOUS and frame.type_id == _ALLOCATION:
            self.nameless += 1
        payload = self._receiver.on_frame(message.arbitration_id, bytes(message.data), now_us)
        if payload is None or frame.kind is not Kind.MESSAGE:
            return
        try:
            self._take(frame.type_id, frame.source, payload)
        except ValueError:
            return  # of another version of the data type

    def _take(self, type_id: int, node: int, payload: bytes) -> None:
        if type_id == NODE_STATUS.type_id:
            status = NodeStatus.decode(payload)
            before = self.status.get(node)
            self.restarts[node] += before is not None and status.uptime_s < before.uptime_s
            self.status[node] = status
        elif type_id == ESC_STATUS.type_id:
            self.escs[EscStatus.decode(payload).esc_index].add(node)
        else:
            self.commanders.add(node)


def listen(bus: can.BusABC, seconds: float) -> Nodes:
    """Listen to a bus for `seconds`."""
    nodes = Nodes()
    end_s = time.monotonic() + seconds
    while (left_s := end_s - time.monotonic()) > 0:
        message = bus.recv(left_s)
        if message is not None:
            nodes.hear(message, time.monotonic_ns() // 1000)
    return nodes


def bus_nodes(boat: Boat, seconds: float) -> Iterator[Finding]:
    """Listen to the boat's bus and judge its nodes."""
    scheme, _, channel = boat.can.partition(":")
    try:
        with can.Bus(interface=scheme, channel=channel) as bus:
            nodes = listen(bus, seconds)
    except (OSError, can.CanError) as error:
        yield bad(boat.can, f"cannot be opened: {error}", "`ip link` lists interfaces; see above")
        return
    yield from judge(boat, nodes)


def judge(boat: Boat, nodes: Nodes) -> Iterator[Finding]:
    """Findings about the bus's nodes for this boat."""
    own = round(boat.parameters.get("CAN_NODE", 0))
    others = set(nodes.status) - {own}
    if not others and not nodes.escs:
        if nodes.nameless:
            remedy = "start flotillad: it assigns node ids"
            yield bad(
                boat.can, "motor controllers request a node id, but no node assigns one", remedy
            )
        else:
            yield bad(boat.can, "no motor controller is heard", _POWER)
        return
    for name in ("ESC_PORT", "ESC_STBD"):
        index = round(boat.parameters.get(name, name == "ESC_STBD"))
        heard = nodes.escs.get(index, set())
        set_it = "set it with the motor controller's own tool (index, not node id)"
        if not heard:
            what = f"no motor controller has the index {index} ({name}); heard: {_list(nodes.escs)}"
            yield bad(boat.can, what, f"{_POWER}; {set_it}, or {name}")
        elif len(heard) > 1:
            yield bad(
                boat.can, f"nodes {_list(heard)} both have the index {index} ({name})", set_it
            )
        else:
            yield ok(boat.can, f"motor controller {index} ({name}) is node {_list(heard)}")
    yield from _health(boat.can, nodes, others)
    strangers = nodes.commanders - {own}
    if strangers:
        yield bad(
            boat.can,
            f"node {_list(strangers)} commands the motor controllers too",
            "remove the autopilot from this bus: one node may command (firmware/docs/AUTOPILOT.md)",
        )


def _health(where: str, nodes: Nodes, others: set[int]) -> Iterator[Finding]:
    for node in sorted(others):
        health = nodes.status[node].health
        if nodes.restarts[node] > 1:
            what = f"two nodes share the id {node}, or the node keeps restarting"
            yield bad(
                where,
                what,
                "give each its own id, or 0 for one from the boat; check their supply",
            )
        if health:
            tell = bad if health > 1 else doubt
            remedy = "look up its error with its own tool; check its temperature and supply first"
            yield tell(where, f"node {node} reports health {_HEALTH[health]}", remedy)


def _list(numbers: object) -> str:
    assert isinstance(numbers, set | dict)
    return ", ".join(map(str, sorted(numbers))) or "none"
