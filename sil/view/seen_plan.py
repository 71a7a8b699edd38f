# SPDX-License-Identifier: MIT
"""Plans, fences and rally points of vessels, overheard from the mission protocol's traffic.

A plan from a ground station counts once the vessel has accepted it. A plan that a vessel sends to a
station counts once its last item has passed. Source: mavlink.io, mission protocol, plan file
commands.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from math import isfinite
from typing import Any, NamedTuple

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.wire import mavlink_messages as messages
from sil.wire.mavlink_ear import Message

MISSION, FENCE, RALLY = 0, 1, 2
_ALL = 255
MOST_ITEMS = 2000
_FRAMES = {0, 3, 5, 6, 11}  # global
_POLYGONS = {
    mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION: True,
    mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_EXCLUSION: False,
}
_CIRCLES = {
    mavlink.MAV_CMD_NAV_FENCE_CIRCLE_INCLUSION: True,
    mavlink.MAV_CMD_NAV_FENCE_CIRCLE_EXCLUSION: False,
}
_LEADS_TO = {
    mavlink.MAV_CMD_NAV_WAYPOINT,
    mavlink.MAV_CMD_NAV_LOITER_UNLIM,
    mavlink.MAV_CMD_NAV_LOITER_TURNS,
    mavlink.MAV_CMD_NAV_LOITER_TIME,
    mavlink.MAV_CMD_USER_1,  # a voyage that measures the hull
}

#: North and east, m, of a latitude and longitude in degE7; None if it cannot be converted.
Convert = Callable[[int, int], tuple[float, float] | None]


class Item(NamedTuple):
    """The drawing of an item."""

    number: int
    command: int
    first: float  # parameter 1, 0 if it is not finite
    place: tuple[int, int]  # degE7


Items = tuple[Item, ...]


@dataclass
class _Draft:
    """A transfer under way; `count` is None if the number of items was not heard."""

    count: int | None
    items: dict[int, Item] = field(default_factory=dict)

    def whole(self) -> Items | None:
        count = len(self.items) if self.count is None else self.count
        there = all(number in self.items for number in range(count))
        return tuple(self.items[number] for number in range(count)) if there else None


class Plans:
    """The plans of all vessels. `is_vessel`: whether a system is a vessel, not a ground station.

    `version` changes with any plan. `item`: by system id, the current item of MISSION_CURRENT.
    """

    def __init__(self, is_vessel: Callable[[int], bool]) -> None:
        self.version = 0
        self.item: dict[int, int] = {}
        self._is_vessel = is_vessel
        self._drafts: dict[tuple[int, int, int], _Draft] = {}  # sender, receiver, type
        self._clearing: set[tuple[int, int, int]] = set()
        self._plans: dict[int, dict[int, Items]] = {}

    def of(self, system: int) -> dict[int, Items]:
        """The plan (MISSION), fence and rally points of a vessel, as far as known."""
        return self._plans.get(system, {})

    def systems(self) -> list[int]:
        """Vessels with a known plan, fence or rally point."""
        return sorted(self._plans)

    def forget(self, system: int) -> None:
        """Forget a vessel."""
        self.version += self._plans.pop(system, None) is not None
        self.item.pop(system, None)

    def hear(self, message: Message) -> None:
        """Process any message."""
        if not message.fields:
            return
        sender, f = message.system, message.fields
        match message.number:
            case messages.MISSION_CURRENT:
                self.item[sender] = f[0]
            case messages.MISSION_COUNT:
                self._begin(sender, f[1], f[3], f[0])
            case messages.MISSION_ITEM_INT:
                self._take(sender, f[9], f)
            case messages.MISSION_CLEAR_ALL:
                self._clearing.add((sender, f[0], f[2]))
            case messages.MISSION_ACK:
                self._accept(f[0], sender, f[3], f[2])

    def _begin(self, sender: int, receiver: int, kind: int, count: int) -> None:
        if count > MOST_ITEMS:
            return
        self._drafts[sender, receiver, kind] = _Draft(count)
        if count == 0 and self._is_told(sender, receiver):
            self._set(sender, kind, ())

    def _take(self, sender: int, receiver: int, f: tuple[Any, ...]) -> None:
        number, command, frame, kind = f[7], f[8], f[11], f[14]
        if number >= MOST_ITEMS:
            return
        draft = self._drafts.setdefault((sender, receiver, kind), _Draft(None))
        place = (f[4], f[5]) if frame in _FRAMES else (0, 0)
        first = f[0] if isfinite(f[0]) else 0.0
        draft.items[number] = Item(number, command, first, place)
        if self._is_told(sender, receiver) and draft.count is not None:
            whole = draft.whole()
            if whole is not None:
                self._set(sender, kind, whole)

    def _accept(self, station: int, vessel: int, kind: int, result: int) -> None:
        """Process a vessel's answer to a station."""
        draft = self._drafts.pop((station, vessel, kind), None)
        cleared = [key for key in self._clearing if key[:2] == (station, vessel)]
        self._clearing.difference_update(cleared)
        if result != mavlink.MAV_MISSION_ACCEPTED or not self._is_vessel(vessel):
            return
        if draft is not None and (whole := draft.whole()) is not None:
            self._set(vessel, kind, whole)
            return
        for _, _, what in cleared:
            for one in (MISSION, FENCE, RALLY) if what == _ALL else (what,):
                self._set(vessel, one, ())

    def _is_told(self, sender: int, receiver: int) -> bool:
        """Whether a vessel sends to a station, rather than the other way round."""
        return self._is_vessel(sender) and not self._is_vessel(receiver)

    def _set(self, system: int, kind: int, items: Items) -> None:
        if self._plans.setdefault(system, {}).get(kind) != items:
            self._plans[system][kind] = items
            self.version += 1


def drawn(plan: dict[int, Items], convert: Convert) -> dict[str, Any]:
    """A vessel's plan for the page.

    `way`: [north, east, item] of each place; `fence`: {"inside", "points"} or {"inside", "centre",
    "radius_m"}; `rally`: [north, east]. Lengths in m, in the frame of `convert`; places that cannot
    be converted are left out.
    """

    def at(item: Item) -> list[float] | None:
        found = None if item.place == (0, 0) else convert(*item.place)
        return None if found is None else [round(found[0], 2), round(found[1], 2)]

    way = [
        [*place, item.number]
        for item in plan.get(MISSION, ())
        if item.command in _LEADS_TO and (place := at(item))
    ]
    rally = [
        place
        for item in plan.get(RALLY, ())
        if item.command == mavlink.MAV_CMD_NAV_RALLY_POINT and (place := at(item))
    ]
    return {"way": way, "fence": _fence(plan.get(FENCE, ()), at), "rally": rally}


def _fence(items: Items, at: Callable[[Item], list[float] | None]) -> list[dict[str, Any]]:
    """Circles and polygons; each corner of a polygon contains the number of corners.

    Leaves out a circle without a radius and a corner without a number.
    """
    shapes: list[dict[str, Any]] = []
    corners: list[list[float]] = []
    for item in items:
        place = at(item)
        if place is None or item.first <= 0.0:
            continue
        if item.command in _CIRCLES:
            circle = {"inside": _CIRCLES[item.command], "centre": place, "radius_m": item.first}
            shapes.append(circle)
        elif item.command in _POLYGONS:
            corners.append(place)
            if len(corners) >= item.first:
                shapes.append({"inside": _POLYGONS[item.command], "points": corners})
                corners = []
    return shapes
