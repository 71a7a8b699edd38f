# SPDX-License-Identifier: MIT
"""Plans as a ground station sends and fetches them, by MAVLink's guide and pymavlink's encoder."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from typing import Any, NamedTuple

from pymavlink.dialects.v20 import common as mavlink

from tests.target.sea import Sea, Tick
from tests.target.stations import BOAT, ORIGIN, REQUEST_MESSAGE, Station

#: MAV_MISSION_TYPE.
PLAN, FENCE, RALLY, ALL = 0, 1, 2, 255
WAYPOINT, LOITER_UNLIMITED, LOITER_TURNS, LOITER_TIME, RETURN = 16, 17, 18, 19, 20
DELAY, JUMP, SPEED = 93, 177, 178
RETURN_POINT, KEEP_IN, KEEP_OUT, CIRCLE_IN, CIRCLE_OUT, RALLY_POINT = *range(5000, 5005), 5100
GLOBAL_RELATIVE_ALT_INT = 6
ITEM_ACCEPTED, ERROR, UNSUPPORTED_FRAME, UNSUPPORTED_ITEM, NO_SPACE, INVALID = 0, 1, 2, 3, 4, 5
INVALID_PARAM1, INVALID_PARAM2, INVALID_X, INVALID_Y, BAD_SEQUENCE = 6, 7, 10, 11, 13
REFUSED, CANCELLED = 14, 15
#: Metres in a ten-millionth of a degree of latitude, on the ellipsoid where the boats are.
DEGREES_E7_M = 0.0111178


class Item(NamedTuple):
    """A MISSION_ITEM_INT without target and number."""

    command: int = WAYPOINT
    params: tuple[float, float, float, float] = (0.0, 0.0, 0.0, math.nan)
    x: int = ORIGIN[0]
    y: int = ORIGIN[1]
    z: float = 0.0
    frame: int = GLOBAL_RELATIVE_ALT_INT
    autocontinue: int = 1

    def message(self, seq: int, *, kind: int = 0, target: tuple[int, int] = (BOAT, 1)) -> Any:
        return mavlink.MAVLink_mission_item_int_message(
            *target,
            seq,
            self.frame,
            self.command,
            0,
            self.autocontinue,
            *self.params,
            self.x,
            self.y,
            self.z,
            kind,
        )


def at(north_m: float, east_m: float, hold_s: float = 0.0, radius_m: float = 0.0) -> Item:
    """A waypoint at this distance from the origin."""
    east = DEGREES_E7_M * math.cos(math.radians(ORIGIN[0] * 1e-7))
    return Item(
        params=(hold_s, radius_m, 0.0, math.nan),
        x=ORIGIN[0] + round(north_m / DEGREES_E7_M),
        y=ORIGIN[1] + round(east_m / east),
    )


def bare(command: int, *params: float) -> Item:
    """An item without a place."""
    a, b = (*params, 0.0, 0.0)[:2]
    return Item(command, (a, b, 0.0, 0.0), 0, 0, frame=2)


def turns(north_m: float, east_m: float, count: float, radius_m: float) -> Item:
    params = (count, 0.0, radius_m, math.nan)
    return at(north_m, east_m)._replace(command=LOITER_TURNS, params=params)


def speed(metres_per_s: float) -> Item:
    return Item(SPEED, (1.0, metres_per_s, -1.0, 0.0), 0, 0, frame=2)


def corners(
    command: int, places: Sequence[tuple[float, float]], frame: int = GLOBAL_RELATIVE_ALT_INT
) -> list[Item]:
    """A polygon of a fence: 5001 to stay inside, 5002 to stay outside."""
    count = float(len(places))
    return [
        at(*place)._replace(command=command, params=(count, 0.0, 0.0, 0.0), frame=frame)
        for place in places
    ]


def box(north_m: float, east_m: float, half_m: float, command: int = KEEP_IN) -> list[Item]:
    """A square round a point."""
    n, e, h = north_m, east_m, half_m
    return corners(command, [(n - h, e - h), (n - h, e + h), (n + h, e + h), (n + h, e - h)])


def circle(north_m: float, east_m: float, radius_m: float, command: int = CIRCLE_IN) -> Item:
    params = (radius_m, 0.0, 0.0, 0.0)
    return at(north_m, east_m)._replace(command=command, params=params)


def rally(north_m: float, east_m: float) -> Item:
    return at(north_m, east_m)._replace(command=RALLY_POINT, params=(0.0, 0.0, 0.0, 0.0))


def fields(message: Any) -> tuple[bytes, ...]:
    """The item in a message, as bytes: NaN equals itself."""
    return (
        *(bytes(mavlink.struct.pack("<f", getattr(message, f"param{k}"))) for k in (1, 2, 3, 4)),
        mavlink.struct.pack("<iif", message.x, message.y, message.z),
        mavlink.struct.pack("<HBB", message.command, message.frame, message.autocontinue),
    )


class Planner:
    """A ground station that sends a plan, or fetches it, over a link that loses messages.

    By the guide: it repeats a request up to five times, each after 1.5 s without an answer; if the
    boat misses an item, the boat must request it again. It fetches with more tries than the guide.
    """

    PATIENCE_US, TRIES, FETCHES = 1_500_000, 5, 20

    def __init__(
        self, sea: Sea, *, station: Station | None = None, loss: float = 0.0, kind: int = PLAN
    ) -> None:
        self.sea = sea
        self.kind = kind
        self.station = station or sea.gcs
        self._dice = random.Random(7)
        self._loss = loss

    def say(self, message: Any) -> None:
        wire = self.station.pack(message)
        if self._dice.random() >= self._loss:
            self.sea.boat.on_mavlink(wire, self.sea.now_us)

    def hear(self, tick: Tick) -> list[Any]:
        """The boat's messages of the mission protocol that have reached this station."""
        return [
            m
            for m in tick.messages()
            if m.get_type().startswith("MISSION_")
            and getattr(m, "target_system", 0) == self.station.system
            and self._dice.random() >= self._loss
        ]

    def send(self, items: Sequence[Item], *, count: int | None = None) -> int | None:
        """Send a plan; the type of the boat's MISSION_ACK, None if it never came."""
        opening: Any = mavlink.MAVLink_mission_count_message(
            BOAT, 1, len(items) if count is None else count, self.kind
        )
        last = opening
        self.say(last)
        asked_us, tries = self.sea.now_us, 0
        while tries < self.TRIES:
            for m in self.hear(self.sea.step()):
                if m.get_type() == "MISSION_ACK":
                    return int(m.type)
                if m.get_type() == "MISSION_REQUEST_INT" and m.seq < len(items):
                    last = items[m.seq].message(m.seq, kind=self.kind)
                    self.say(last)
                    asked_us, tries = self.sea.now_us, 0
            if self.sea.now_us - asked_us > self.PATIENCE_US:
                self.say(last)
                asked_us, tries = self.sea.now_us, tries + 1
        return None

    def fetch(self) -> list[Any]:
        """The boat's plan: its MISSION_ITEM_INT messages."""
        kind = self.kind
        listed = mavlink.MAVLink_mission_request_list_message(BOAT, 1, kind)
        items = [
            self._ask(
                mavlink.MAVLink_mission_request_int_message(BOAT, 1, seq, kind), "ITEM_INT", seq
            )
            for seq in range(self._ask(listed, "COUNT").count)
        ]
        self.say(mavlink.MAVLink_mission_ack_message(BOAT, 1, 0, kind))
        return items

    def _ask(self, question: Any, answer: str, seq: int | None = None) -> Any:
        for _ in range(self.FETCHES):
            self.say(question)
            end_us = self.sea.now_us + self.PATIENCE_US
            while self.sea.now_us < end_us:
                for m in self.hear(self.sea.step()):
                    ours = m.get_type() == f"MISSION_{answer}" and m.mission_type == self.kind
                    if ours and seq in (None, getattr(m, "seq", 0)):
                        return m
        raise AssertionError(f"no MISSION_{answer} {seq}")


def send(sea: Sea, kind: int, items: Sequence[Item]) -> int | None:
    """Send a plan, fence or rally points from the ground station, as Planner.send."""
    return Planner(sea, kind=kind).send(items)


def plan_of(sea: Sea, kind: int = PLAN) -> list[tuple[bytes, ...]]:
    """The plan, fence or rally points that the boat has."""
    return [fields(m) for m in Planner(sea, station=Station(254, 190), kind=kind).fetch()]


def as_sent(items: Sequence[Item]) -> list[tuple[bytes, ...]]:
    return [fields(item.message(seq)) for seq, item in enumerate(items)]


def opaque_id(payload: bytes, at: int) -> int:
    """An extension that pymavlink's messages lack; trailing zeros are not sent."""
    return int.from_bytes(payload[at : at + 4], "little")


def ids(sea: Sea) -> tuple[int, int]:
    """The plan's id in MISSION_COUNT and in MISSION_CURRENT; 0 without a message."""
    sea.say(mavlink.MAVLink_mission_request_list_message(BOAT, 1, 0))
    (count,) = sea.run(0.1)[0].payloads(mavlink.MAVLINK_MSG_ID_MISSION_COUNT)
    asked = sea.order(REQUEST_MESSAGE, float(mavlink.MAVLINK_MSG_ID_MISSION_CURRENT))
    current = asked.payloads(mavlink.MAVLINK_MSG_ID_MISSION_CURRENT)
    return opaque_id(count, 5), opaque_id(current[-1], 6) if current else 0
