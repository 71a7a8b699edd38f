# SPDX-License-Identifier: MIT
"""A boat of your own simulator, steered by a real flotillad in real time.

    python sil/examples/my_simulator.py build/release/firmware/flotillad

A simulator needs three things: it sends the boat's state as MAVLink, takes the thrust commands that
flotillad sends over CAN as DroneCAN, and answers as motor controllers (ESCs) do. Replace `Boat` by
your own model. The bus is UDP multicast, which needs neither CAN hardware nor root.
"""

import math
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import dronecan
from pymavlink import mavutil

from sil.live.ordinary_user import ordinary_user
from sil.live.parameter_file import set_up

SECONDS, STEP_S = 40.0, 0.02
BOAT, LEADER, OPERATOR = 1, 100, 255  # MAVLink system ids
SLOT_NORTH_M, SLOT_EAST_M = -3.0, 2.0  # relative to the leader
ORIGIN = (473977420, 85455940, 400000)  # latitude, longitude degE7, altitude mm: north 0, east 0
FULL_N, ARM_M = 20.0, 0.25  # thrust of a propeller at full command; half the distance between them
RAW_FULL = 8191
FORMATION, ARM, SET_MODE = 6, 400, 176  # Rover's FOLLOW; MAV_CMD_COMPONENT_ARM_DISARM, _DO_SET_MODE


class Boat:
    """The model, at rest at first; put your own here."""

    def __init__(self) -> None:
        self.north, self.east, self.psi = -8.0, -4.0, 1.0
        self.u = self.v = self.r = 0.0

    def step(self, port_N: float, stbd_N: float, h_s: float) -> None:
        """Advance by `h_s` with these thrusts."""
        u, v, r = self.u, self.v, self.r
        self.u += h_s * (port_N + stbd_N + 1.982 * v * r - 3.436 * u) / 1.012
        self.v += h_s * (-1.012 * u * r - 18.99 * v) / 1.982
        self.r += h_s * (ARM_M * (port_N - stbd_N) - 0.97 * u * v - 0.864 * r) / 0.354
        self.north += h_s * (u * math.cos(self.psi) - v * math.sin(self.psi))
        self.east += h_s * (u * math.sin(self.psi) + v * math.cos(self.psi))
        self.psi = math.remainder(self.psi + h_s * r, math.tau)


class Esc:
    """A motor controller on the bus; `thrust_N` is the thrust that flotillad commands."""

    def __init__(self, bus: int, index: int) -> None:
        self.index, self.thrust_N = index, 0.0
        info = dronecan.uavcan.protocol.GetNodeInfo.Response(name="my.simulator.esc")
        self.node = dronecan.make_node(
            str(bus), node_id=50 + index, node_info=info, bustype="mcast", bitrate=1_000_000
        )
        self.node.mode = dronecan.uavcan.protocol.NodeStatus().MODE_OPERATIONAL
        self.node.add_handler(dronecan.uavcan.equipment.esc.RawCommand, self._obey)

    def _obey(self, event: dronecan.node.TransferEvent) -> None:
        self.thrust_N = FULL_N * event.message.cmd[self.index] / RAW_FULL

    def report(self) -> None:
        """Send esc.Status; flotillad arms only when it has heard both."""
        rpm = round(100.0 * self.thrust_N)
        status = dronecan.uavcan.equipment.esc.Status(
            esc_index=self.index, voltage=24.0, temperature=300.0, rpm=rpm
        )
        self.node.broadcast(status)


class Link:
    """One of flotillad's UDP links; `address` is its --mavlink."""

    def __init__(self) -> None:
        self.udp = mavutil.mavlink_connection("udpin:127.0.0.1:0")  # any free port
        self.address = f"udpout:127.0.0.1:{self.udp.port.getsockname()[1]}"

    def speaker(self, system: int, component: int) -> mavutil.mavlink.MAVLink:
        """A sender of messages with this address over the link."""
        return mavutil.mavlink.MAVLink(self.udp, system, component)


def now_ms() -> int:
    """The time since boot of MAVLink's messages."""
    return time.monotonic_ns() // 1_000_000 % (1 << 32)


def send_state(
    unit: mavutil.mavlink.MAVLink, pose: tuple[float, ...], nu: tuple[float, ...]
) -> None:
    """Send a vessel's state; used for the boat's navigation unit and for the leader."""
    (north, east, psi), (u, v, r) = pose, nu
    velocity = (u * math.cos(psi) - v * math.sin(psi), u * math.sin(psi) + v * math.cos(psi))
    unit.attitude_send(now_ms(), 0.0, 0.0, psi, 0.0, 0.0, r)
    unit.local_position_ned_send(now_ms(), north, east, 0.0, *velocity, 0.0)


def send_identity(unit: mavutil.mavlink.MAVLink) -> None:
    """Send messages that change seldom: the vessel's heartbeat, and the place of the origin."""
    unit.heartbeat_send(0, mavutil.mavlink.MAV_AUTOPILOT_GENERIC, 0, 0, 0)
    unit.gps_global_origin_send(*ORIGIN)


def listen(link: Link, unit: mavutil.mavlink.MAVLink) -> None:
    """Answer TIMESYNC, from which flotillad learns how old states are; print its STATUSTEXT."""
    while message := link.udp.recv_msg():
        if message.get_type() == "TIMESYNC" and message.tc1 == 0:
            unit.timesync_send(time.monotonic_ns(), message.ts1)
        elif message.get_type() == "STATUSTEXT":
            print("      ", message.text)


def sail(program: str, bus: int = 8) -> float:
    """Sail behind a leader that goes north at 0.5 m/s; the final distance from the slot, m."""
    boat, port, stbd = Boat(), Esc(bus, 0), Esc(bus, 1)
    navigation, radio = Link(), Link()
    unit, leader = navigation.speaker(BOAT, 1), radio.speaker(LEADER, 1)
    operator = radio.speaker(OPERATOR, 190)
    parameters = {"MAV_SYSID": BOAT, "MAV_COMPID": 10, "FORM_LEADER": LEADER, "THR_FWD_MAX": FULL_N}
    parameters |= {"FORM_OFS_N": SLOT_NORTH_M, "FORM_OFS_E": SLOT_EAST_M, "THR_ARM": ARM_M}
    with tempfile.TemporaryDirectory() as state:
        set_up(Path(state), parameters)
        options = [f"--can=mcast:{bus}", f"--state-dir={state}"]
        options += [f"--mavlink={link.address}" for link in (navigation, radio)]
        flotillad = subprocess.Popen([*ordinary_user(), program, *options])
        try:
            begin_s, tick, off_m = time.monotonic(), 0, math.inf
            while tick * STEP_S < SECONDS:
                port.node.spin(max(0.0, begin_s + tick * STEP_S - time.monotonic()))
                stbd.node.spin(0.0)
                boat.step(port.thrust_N, stbd.thrust_N, STEP_S)
                lead_m = 0.5 * tick * STEP_S
                listen(navigation, unit)
                listen(radio, leader)
                if tick % 5 == 0:  # 10 Hz
                    send_state(unit, (boat.north, boat.east, boat.psi), (boat.u, boat.v, boat.r))
                    send_state(leader, (lead_m, 0.0, 0.0), (0.5, 0.0, 0.0))
                    port.report()
                    stbd.report()
                if tick % 50 == 0:  # 1 Hz
                    send_identity(unit)
                    send_identity(leader)
                    operator.heartbeat_send(6, mavutil.mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4)
                    off_m = math.hypot(boat.north - lead_m - SLOT_NORTH_M, boat.east - SLOT_EAST_M)
                    print(f"{tick * STEP_S:4.0f} s: {off_m:.2f} m from the slot")
                if tick == 250:
                    operator.command_long_send(BOAT, 10, ARM, 0, 1, 0, 0, 0, 0, 0, 0)
                if tick == 300:
                    operator.command_long_send(BOAT, 10, SET_MODE, 0, 1, FORMATION, 0, 0, 0, 0, 0)
                tick += 1
            return off_m
        finally:
            flotillad.terminate()
            flotillad.wait()
            for connection in (port.node, stbd.node, navigation.udp, radio.udp):
                connection.close()


if __name__ == "__main__":
    sail(sys.argv[1])
