# SPDX-License-Identifier: MIT
"""The doctor on the kernel's CAN: an interface that is up, one that is down, and who is on it."""

import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import can

from sil.doctor.boat_file import Boat
from sil.doctor.bus_nodes import bus_nodes
from sil.doctor.can_interface import can_interface
from sil.doctor.computer import Computer
from sil.doctor.finding import Level
from sil.wire.esc_node import EscNode
from tests.vcan.bus import run

BOAT = Boat("socketcan:vcan0", parameters={"ESC_PORT": 0, "ESC_STBD": 1, "CAN_NODE": 20})


def told() -> list[str]:
    return [f.what for f in can_interface(Computer(Path("/")), BOAT)]


def test_a_virtual_bus_is_reported_and_so_is_one_that_is_down() -> None:
    assert told() == ["is a virtual bus: no motor controller hears it"]
    run("ip", "link", "set", "vcan0", "down")
    try:
        assert told() == ["is down"]
    finally:
        run("ip", "link", "set", "vcan0", "up")


def test_motor_controllers_are_heard_by_socketcan() -> None:
    escs = [EscNode(31, 0), EscNode(32, 1)]
    with ThreadPoolExecutor(1) as pool, can.Bus(interface="socketcan", channel="vcan0") as bus:
        future = pool.submit(lambda: list(bus_nodes(BOAT, 1.0)))
        while not future.done():
            bus.recv(0.01)
            for esc in escs:
                for can_id, data in esc.tick(time.monotonic_ns() // 1000, 0.0, 24.0, 0.1):
                    bus.send(can.Message(arbitration_id=can_id, data=data, is_extended_id=True))
    assert [(f.level, f.what) for f in future.result()] == [
        (Level.OK, "motor controller 0 (ESC_PORT) is node 31"),
        (Level.OK, "motor controller 1 (ESC_STBD) is node 32"),
    ]
