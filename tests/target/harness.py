# SPDX-License-Identifier: MIT
"""A sea for one boat: navigation unit, leader, ground station, two ESCs, one virtual clock.

Wire: pymavlink and PyPI dronecan only, so that no mistake of ours can cancel. SI units, radians.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any

import dronecan
import flotilla
from dronecan.transport import Frame, Transfer, TransferManager
from hypothesis import settings
from pymavlink.dialects.v10 import common as mavlink1
from pymavlink.dialects.v20 import common as mavlink

BOAT, LEADER, GCS, STRANGER = 2, 1, 255, 77
NAVIGATION, LEADER_COMPONENT, GCS_COMPONENT = 197, 1, 190
ARM, SET_MODE, FORCE = 400, 176, 21196
HOLD, FORMATION = 4, 6
ARMED_BIT = 128
ORIGIN = (473977420, 85455940, 488000)
UNKNOWN_COVARIANCE = [math.nan] + [0.0] * 20
START_US = 10_000_000
RAW_COMMAND, ESC_STATUS, ARMING_STATUS, NODE_STATUS, GET_NODE_INFO = 1030, 1034, 1100, 341, 1
FULL_SCALE = 8191

Frames = list[tuple[int, bytes]]

#: Hypothesis with the same examples in every run.
seeded = functools.partial(settings, derandomize=True, database=None, deadline=None)


class Station:
    """Whoever talks MAVLink, with pymavlink's own encoder and sequence numbers."""

    def __init__(self, system: int, component: int = 1) -> None:
        self.system, self.component = system, component
        self.encoder = mavlink.MAVLink(None, system, component)

    def pack(self, *messages: Any, version1: bool = False) -> bytes:
        wire = b""
        for message in messages:
            wire += bytes((as_version1(message) if version1 else message).pack(self.encoder))
            self.encoder.seq = (self.encoder.seq + 1) % 256
        return wire


def as_version1(message: Any) -> Any:
    """The message in pymavlink's MAVLink 1 dialect; its v2 one puts extensions into v1 frames."""
    kind = getattr(mavlink1, type(message).__name__)
    return kind(*[getattr(message, name) for name in kind.fieldnames])


def signed(station: Station, key: bytes = b"k" * 32) -> Station:
    station.encoder.signing.secret_key = key
    station.encoder.signing.sign_outgoing = True
    station.encoder.signing.link_id = 3
    station.encoder.signing.timestamp = 1
    return station


@dataclass(frozen=True)
class Course:
    """Truth at t = 0 and from then on: constant body velocity and yaw rate."""

    north: float = 0.0
    east: float = 0.0
    psi: float = 0.0
    u: float = 0.0
    v: float = 0.0
    r: float = 0.0

    def at(self, t_s: float) -> Course:
        if self.r == 0.0:
            ahead, abeam = t_s, 0.0
        else:
            ahead = math.sin(self.r * t_s) / self.r
            abeam = (1.0 - math.cos(self.r * t_s)) / self.r
        forward, starboard = self.u * ahead - self.v * abeam, self.u * abeam + self.v * ahead
        c, s = math.cos(self.psi), math.sin(self.psi)
        return Course(
            self.north + c * forward - s * starboard,
            self.east + s * forward + c * starboard,
            wrap(self.psi + self.r * t_s),
            self.u,
            self.v,
            self.r,
        )

    @property
    def velocity_n(self) -> tuple[float, float]:
        c, s = math.cos(self.psi), math.sin(self.psi)
        return c * self.u - s * self.v, s * self.u + c * self.v


def wrap(angle: float) -> float:
    return math.atan2(math.sin(angle), math.cos(angle))


def quaternion(roll: float, pitch: float, yaw: float) -> list[float]:
    """Body to north-east-down, w first."""
    cr, sr = math.cos(roll / 2), math.sin(roll / 2)
    cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
    cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
    return [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ]


def odometry(truth: Course, time_us: int, **changes: Any) -> Any:
    """ODOMETRY of a level boat: LOCAL_NED, velocity in BODY_FRD; any field may be changed."""
    fields: dict[str, Any] = {
        "time_usec": time_us,
        "frame_id": 1,
        "child_frame_id": 12,
        "x": truth.north,
        "y": truth.east,
        "z": 0.0,
        "q": quaternion(0.0, 0.0, truth.psi),
        "vx": truth.u,
        "vy": truth.v,
        "vz": 0.0,
        "rollspeed": 0.0,
        "pitchspeed": 0.0,
        "yawspeed": truth.r,
        "pose_covariance": UNKNOWN_COVARIANCE,
        "velocity_covariance": UNKNOWN_COVARIANCE,
        "reset_counter": 0,
        "estimator_type": 8,
        "quality": 0,
    }
    return mavlink.MAVLink_odometry_message(**(fields | changes))


def local_position(truth: Course, time_us: int, **changes: Any) -> Any:
    north, east = truth.velocity_n
    fields = {
        "time_boot_ms": time_us // 1000 % 2**32,
        "x": truth.north,
        "y": truth.east,
        "z": 0.0,
        "vx": north,
        "vy": east,
        "vz": 0.0,
    }
    return mavlink.MAVLink_local_position_ned_message(**(fields | changes))


def attitude(truth: Course, time_us: int, **changes: Any) -> Any:
    fields = {
        "time_boot_ms": time_us // 1000 % 2**32,
        "roll": 0.0,
        "pitch": 0.0,
        "yaw": truth.psi,
        "rollspeed": 0.0,
        "pitchspeed": 0.0,
        "yawspeed": truth.r,
    }
    return mavlink.MAVLink_attitude_message(**(fields | changes))


def origin(
    time_us: int = 0,
    latitude: int = ORIGIN[0],
    longitude: int = ORIGIN[1],
    altitude: int = ORIGIN[2],
) -> Any:
    return mavlink.MAVLink_gps_global_origin_message(latitude, longitude, altitude, time_us)


def heartbeat(kind: int = mavlink.MAV_TYPE_SURFACE_BOAT) -> Any:
    return mavlink.MAVLink_heartbeat_message(kind, 0, 0, 0, 4, 3)


def command_long(
    command: int, *params: float, target: tuple[int, int] = (BOAT, 1), confirmation: int = 0
) -> Any:
    """COMMAND_LONG whose unused parameters are NaN, as MAVSDK sends them."""
    filled = [*params, *[math.nan] * (7 - len(params))]
    return mavlink.MAVLink_command_long_message(*target, command, confirmation, *filled)


def decode(chunks: Iterable[bytes]) -> list[Any]:
    """Every message in the chunks; whatever is not a good frame comes as BAD_DATA."""
    parser = mavlink.MAVLink(None)
    parser.robust_parsing = True
    return [message for chunk in chunks for message in parser.parse_buffer(chunk) or []]


# --- CAN -----------------------------------------------------------------------------------------


def type_of(can_id: int) -> tuple[bool, int, int]:
    """service?, data type, source node."""
    service = bool(can_id & 0x80)
    return service, (can_id >> 16) & 0xFF if service else (can_id >> 8) & 0xFFFF, can_id & 0x7F


def transfers(frames: Iterable[tuple[int, bytes]]) -> list[Transfer]:
    """What PyPI dronecan makes of the frames; TransferError where it refuses one."""
    manager, complete = TransferManager(), []
    for can_id, data in frames:
        parts = manager.receive_frame(Frame(can_id, data))
        if parts:
            transfer = Transfer()
            transfer.from_frames(parts)
            complete.append(transfer)
    return complete


@functools.cache
def _raw_command(payload: bytes) -> tuple[int, ...]:
    (transfer,) = transfers([(7 << 24 | RAW_COMMAND << 8 | 20, payload + b"\xc0")])
    return tuple(transfer.payload.cmd)


def commands(frames: Frames) -> tuple[int, ...]:
    """Slots of the one RawCommand among a tick's frames."""
    mine = [(i, d) for i, d in frames if type_of(i)[:2] == (False, RAW_COMMAND)]
    if len(mine) == 1:
        assert mine[0][1][-1] & 0xC0 == 0xC0
        return _raw_command(mine[0][1][:-1])
    (transfer,) = transfers(mine)
    return tuple(transfer.payload.cmd)


def arming_statuses(frames: Frames) -> list[int]:
    mine = [f for f in frames if type_of(f[0])[:2] == (False, ARMING_STATUS)]
    return [t.payload.status for t in transfers(mine)]


def to_wire(transfer: Transfer) -> Frames:
    return [(frame.message_id, bytes(frame.bytes)) for frame in transfer.to_frames()]


def esc_status(node: int, index: int, transfer_id: int = 0, **changes: Any) -> Frames:
    fields = {
        "error_count": 0,
        "voltage": 24.5,
        "current": 1.25,
        "temperature": 310.5,
        "rpm": 1234,
        "power_rating_pct": 42,
        "esc_index": index,
    }
    payload = dronecan.uavcan.equipment.esc.Status(**(fields | changes))
    return to_wire(Transfer(transfer_id, node, payload=payload, transfer_priority=16))


def node_status(
    node: int, uptime_s: int, transfer_id: int = 0, health: int = 0, mode: int = 0
) -> Frames:
    payload = dronecan.uavcan.protocol.NodeStatus(
        uptime_sec=uptime_s, health=health, mode=mode, sub_mode=0, vendor_specific_status_code=0
    )
    return to_wire(Transfer(transfer_id, node, payload=payload, transfer_priority=20))


def node_info_request(asker: int, node: int, transfer_id: int = 0) -> Frames:
    payload = dronecan.uavcan.protocol.GetNodeInfo.Request()
    transfer = Transfer(transfer_id, asker, node, None, 24, True, True)
    transfer.payload = bytearray()  # Transfer() refuses an empty payload
    kind = dronecan.get_dronecan_data_type(payload)
    transfer.data_type_id, transfer.data_type_crc = kind.default_dtid, kind.base_crc
    return to_wire(transfer)


@functools.cache
def _esc_status(node: int, index: int, transfer_id: int) -> tuple[tuple[int, bytes], ...]:
    return tuple(esc_status(node, index, transfer_id))


@dataclass
class Esc:
    """An ESC that only says how it is."""

    node: int
    index: int
    on: bool = True
    health: int = 0
    status_period_us: int = 100_000
    sent: int = 0
    beats: int = 0
    next_status_us: int = 0
    next_beat_us: int = 0

    def frames(self, now_us: int) -> Iterator[tuple[int, bytes]]:
        if not self.on:
            return
        if now_us >= self.next_status_us:
            self.next_status_us = now_us + self.status_period_us
            self.sent += 1
            yield from _esc_status(self.node, self.index, self.sent % 32)
        if now_us >= self.next_beat_us:
            self.next_beat_us = now_us + 1_000_000
            self.beats += 1
            yield from node_status(self.node, now_us // 1_000_000, self.beats % 32, self.health)


# --- the sea -------------------------------------------------------------------------------------


@dataclass
class Tick:
    now_us: int
    mavlink: list[tuple[int, bytes]]
    can: Frames

    @property
    def commands(self) -> tuple[int, ...]:
        return commands(self.can)

    def messages(self, link: int = 0) -> list[Any]:
        return decode(data for at, data in self.mavlink if at == link)

    def named(self, name: str, link: int = 0) -> list[Any]:
        return [m for m in self.messages(link) if m.get_type() == name]


@dataclass
class Agent:
    """Somebody who sends its state: the boat's navigation unit or its leader."""

    station: Station
    course: Course
    period_us: int
    on: bool = True
    origin_on: bool = True
    beats: bool = True
    answers_timesync: bool = False
    clock_offset_us: int = 0
    delay_us: int = 0
    next_us: int = 0
    next_second_us: int = 0
    in_flight: list[tuple[int, bytes]] = field(default_factory=list)

    def clock(self, now_us: int) -> int:
        return now_us + self.clock_offset_us

    def truth(self, now_us: int) -> Course:
        return self.course.at((now_us - START_US) * 1e-6)

    def wire(self, now_us: int) -> bytes:
        """What arrives at the boat now."""
        if self.on and now_us >= self.next_us:
            self.next_us = now_us + self.period_us
            self.post(now_us, odometry(self.truth(now_us), self.clock(now_us)))
        if self.on and now_us >= self.next_second_us:
            self.next_second_us = now_us + 1_000_000
            if self.beats:
                self.post(now_us, heartbeat(mavlink.MAV_TYPE_GENERIC))
            if self.origin_on:
                self.post(now_us, origin(self.clock(now_us)))
        due = [data for at, data in self.in_flight if at <= now_us]
        self.in_flight = [(at, data) for at, data in self.in_flight if at > now_us]
        return b"".join(due)

    def post(self, now_us: int, message: Any) -> None:
        self.in_flight.append((now_us + self.delay_us, self.station.pack(message)))

    def hear(self, messages: Iterable[Any], now_us: int) -> None:
        """Answers TIMESYNC requests; they took delay_us to come and the answer takes as long."""
        for message in messages:
            if message.get_type() == "TIMESYNC" and message.tc1 == 0:
                heard_ns = (self.clock(now_us) + self.delay_us) * 1000
                answer = mavlink.MAVLink_timesync_message(heard_ns, message.ts1)
                self.in_flight.append((now_us + 2 * self.delay_us, self.station.pack(answer)))


class Sea:
    """Drives one boat tick by tick; whoever shall fall silent has an `on`."""

    def __init__(
        self,
        parameters: dict[str, float] | None = None,
        links: int = 1,
        scalar: str = "float",
        own: Course | None = None,
        leader: Course | None = None,
        start_us: int = START_US,
    ) -> None:
        given = {"MAV_SYSID": BOAT, "FORM_LEADER": LEADER} | (parameters or {})
        self.boat = flotilla.Boat(given, links, scalar)
        self.period_us: int = round(1e6 / self.boat.parameters()["CTL_RATE"])
        self.now_us = start_us
        own = own or Course(1.0, 2.0, 0.3)
        leader = leader or Course(5.0, 5.0, 0.5)
        self.own = Agent(Station(BOAT, NAVIGATION), own, 50_000, beats=False)
        self.leader = Agent(Station(LEADER, LEADER_COMPONENT), leader, 100_000)
        self.gcs = Station(GCS, GCS_COMPONENT)
        port = int(self.boat.parameters()["ESC_PORT"])
        stbd = int(self.boat.parameters()["ESC_STBD"])
        self.escs = [Esc(31, port), Esc(32, stbd)]
        self.ticks: list[Tick] = []

    # one tick and many

    def step(self) -> Tick:
        """Everybody sends, the boat ticks, time goes on."""
        for agent in (self.own, self.leader):
            wire = agent.wire(self.now_us)
            if wire:
                self.boat.on_mavlink(wire, self.now_us)
        for esc in self.escs:
            for can_id, data in esc.frames(self.now_us):
                self.boat.on_can(can_id, data, self.now_us)
        return self.tick_only()

    def tick_only(self) -> Tick:
        out = self.boat.tick(self.now_us)
        tick = Tick(self.now_us, list(out.mavlink), list(out.can))
        self.ticks.append(tick)
        for agent in (self.own, self.leader):
            if agent.answers_timesync and agent.on:
                agent.hear(tick.messages(), self.now_us)
        self.now_us += self.period_us
        return tick

    def run(self, seconds: float) -> list[Tick]:
        return [self.step() for _ in range(round(seconds * 1e6 / self.period_us))]

    def run_until(self, state: str, seconds: float) -> float:
        """Seconds until the boat says that state."""
        for n in range(round(seconds * 1e6 / self.period_us)):
            self.step()
            if self.state == state:
                return n * self.period_us * 1e-6
        raise AssertionError(f"{self.state}, not {state}, after {seconds} s: {self.snapshot()}")

    # the operator

    def say(self, *messages: Any, sender: Station | None = None, link: int = 0) -> None:
        self.boat.on_mavlink((sender or self.gcs).pack(*messages), self.now_us, link)

    def order(self, command: int, *params: float, link: int = 0, **how: Any) -> Tick:
        """A COMMAND_LONG from the ground station and the tick that follows it."""
        self.say(command_long(command, *params, **how), link=link)
        return self.step()

    def arm(self) -> Tick:
        return self.order(ARM, 1.0)

    def disarm(self) -> Tick:
        return self.order(ARM, 0.0)

    def mode(self, number: int) -> Tick:
        return self.order(SET_MODE, 1.0, float(number))

    def settle(self) -> None:
        """Long enough for every age to be known."""
        self.run(0.3)

    def enter_hold(self) -> None:
        self.settle()
        self.arm()
        self.step()
        assert self.state == "HOLD", self.snapshot()

    def enter_formation(self) -> None:
        self.enter_hold()
        self.mode(FORMATION)
        self.step()
        assert self.state == "FORMATION", self.snapshot()

    # what is known

    @property
    def state(self) -> str:
        return str(self.boat.state)

    def snapshot(self) -> dict[str, Any]:
        return dict(self.boat.snapshot())

    def counter(self, name: str) -> int:
        return int(self.snapshot()["counters"][name])

    def counters(self) -> dict[str, int]:
        return dict(self.snapshot()["counters"])

    def condition(self, name: str) -> bool:
        return bool(self.snapshot()["conditions"][name])

    @property
    def commands(self) -> tuple[int, ...]:
        return self.ticks[-1].commands


def messages(ticks: Iterable[Tick], link: int = 0) -> list[Any]:
    return decode(data for tick in ticks for at, data in tick.mavlink if at == link)


def named(ticks: Iterable[Tick], name: str, link: int = 0) -> list[Any]:
    return [m for m in messages(ticks, link) if m.get_type() == name]


def texts(ticks: Iterable[Tick], link: int = 0) -> list[str]:
    return [m.text for m in named(ticks, "STATUSTEXT", link)]
