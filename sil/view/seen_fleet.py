# SPDX-License-Identifier: MIT
"""All vessels heard, in one local frame. Times are the listener's, s."""

from collections import deque
from collections.abc import Iterable
from math import cos, hypot, radians
from typing import Any, NamedTuple

from sil.view.seen_motion import Origin, Place
from sil.view.seen_plan import Items, Plans, drawn
from sil.view.seen_table import SeenTable
from sil.view.vessel import Vessel
from sil.wire import mavlink_messages as messages
from sil.wire.geodesy import LocalFrame
from sil.wire.mavlink_ear import Message

SILENT_S, FORGOTTEN_S = 5.0, 60.0
_CARRIED_S = 3.0
_ELSEWHERE_M = 50_000.0
_FAR_M = 1e6
_PATIENCE_S = 2.0
_M_PER_DEGE7 = 0.0111
_MOST_TEXTS = 50


class Pose(NamedTuple):
    """North, east (m), heading (rad; None if unknown)."""

    x: float
    y: float
    psi: float | None


class Fleet:
    """Vessels by system id; at most 255.

    The view's frame has the first origin that is received; it moves when all vessels now heard are
    more than 50 km away. A silent boat is never dropped, because its last place is where to
    look for it. Others are dropped after 60 s. `length_m`: length of the boats, which they do not
    send. `plans`: the vessels' plans; `table`: their table.
    """

    def __init__(self, length_m: float) -> None:
        self.systems: dict[int, Vessel] = {}
        self.unknown = 0
        self.origin: Origin | None = None
        self.plans = Plans(self._is_vessel)
        self.table = SeenTable()
        self.texts_heard = 0
        self._texts: deque[tuple[int, float, int, int | None, str]] = deque(maxlen=_MOST_TEXTS)
        self._length_m = length_m
        self._drawn: tuple[object, dict[int, Any]] = (None, {})
        self._frames: dict[Origin, LocalFrame] = {}
        self._slots: dict[int, tuple[float, float]] = {}  # north, east from the leader

    @property
    def ignored(self) -> int:
        """Number of messages so far from systems that are not vessels."""
        return self.unknown + sum(v.messages for v in self.systems.values() if v.kind is None)

    @property
    def origin_deg(self) -> list[float] | None:
        """Latitude and longitude of the frame's origin; None if unknown."""
        return None if self.origin is None else [1e-7 * self.origin[0], 1e-7 * self.origin[1]]

    def hear(self, heard: Iterable[Message], now_s: float) -> None:
        """Process messages that arrived at `now_s`."""
        for message in heard:
            vessel = self.systems.get(message.system)
            if message.fields is None:
                # Its checksum cannot be verified, so it does not prove that the vessel is alive.
                self.unknown += vessel is None or vessel.kind is None
                continue
            if vessel is None:
                vessel = self.systems[message.system] = Vessel(message.system, now_s)
            before = vessel.texts.last
            vessel.hear(message, now_s)
            if vessel.texts.last != before:
                self._note_text(vessel, now_s)
            self.plans.hear(message)
            if vessel.kind is not None:  # a station's beacons are no member's
                self.table.hear(message, now_s)
            if message.number == messages.GPS_GLOBAL_ORIGIN:
                self._look_at_origin(vessel, now_s)
            elif message.number == messages.POSITION_TARGET_LOCAL_NED:
                self._anchor_slot(vessel, now_s)

    def vessels(self, now_s: float) -> list[dict[str, Any]]:
        """The vessels of a frame for the page, sorted by id; unknown values are None."""
        for vessel in tuple(self.systems.values()):
            if vessel.kind != "boat" and now_s - vessel.heard_s > FORGOTTEN_S:
                del self.systems[vessel.system]
                self._slots.pop(vessel.system, None)
                self.plans.forget(vessel.system)
                self.unknown += vessel.messages if vessel.kind is None else 0
        if self.origin is None:
            self._look_at_globe(now_s)
        known = sorted(k for k, v in self.systems.items() if v.kind is not None)
        return [self._told(self.systems[system], now_s) for system in known]

    def texts(self) -> list[tuple[int, float, int, int | None, str]]:
        """The vessels' last texts: number of the text, time, system id, severity, text."""
        return [text for text in self._texts if self._is_vessel(text[2])]

    def _note_text(self, vessel: Vessel, now_s: float) -> None:
        self.texts_heard += 1
        text = vessel.severity, vessel.texts.last
        self._texts.append((self.texts_heard, round(now_s, 3), vessel.system, *text))

    def drawn_plans(self) -> dict[int, Any]:
        """The drawings of the vessels' plans, by system id: see `seen_plan.drawn`."""
        about = (self.plans.version, self.origin)
        if self._drawn[0] != about:
            systems = [] if self.origin is None else self.plans.systems()
            self._drawn = about, {system: self.drawn(self.plans.of(system)) for system in systems}
        return self._drawn[1]

    def drawn(self, plan: dict[int, Items]) -> dict[str, Any]:
        """The drawing of a plan, in the view's frame."""
        return drawn(plan, self._from_globe)

    def _from_globe(self, latitude: int, longitude: int) -> tuple[float, float] | None:
        if not (abs(latitude) <= 900_000_000 and abs(longitude) <= 1_800_000_000):
            return None
        pose = self._seen(Place(0.0, True, latitude, longitude), None, None)
        near = pose is not None and abs(pose.x) + abs(pose.y) < _FAR_M
        return (pose.x, pose.y) if pose is not None and near else None

    def _is_vessel(self, system: int) -> bool:
        vessel = self.systems.get(system)
        return vessel is not None and vessel.kind is not None

    def _told(self, vessel: Vessel, now_s: float) -> dict[str, Any]:
        vessel.motion.forget(vessel.heard_s - SILENT_S)
        pose, place = self._pose(vessel), vessel.motion.place
        u, v = vessel.motion.body_velocity
        at_s, value = vessel.heard_s, vessel.value
        e_x, e_y, leader = value("E_X"), value("E_Y"), value("LEADER")
        error_m = None if e_x is None or e_y is None else hypot(e_x, e_y)
        thrust, limits = (value("T_PORT"), value("T_STBD")), (value("T_MIN"), value("T_MAX"))
        return {
            "id": vessel.system,
            "kind": vessel.kind,
            "senders": vessel.senders(),
            "x_m": _round(pose and pose.x, 3),
            "y_m": _round(pose and pose.y, 3),
            "place_age_s": None if place is None else round(max(0.0, now_s - place.t_s), 2),
            "psi_rad": _round(pose.psi if pose else vessel.motion.psi_rad, 4),
            "u_mps": _round(u, 3),
            "v_mps": _round(v, 3),
            "length_m": self._length_m,
            "leader": None if leader is None else int(leader),
            "slot": self._slot(vessel, now_s),
            "error_m": _round(error_m, 4),
            "in_slot": value("IN_SLOT"),
            "thrust_N": _pair(thrust),
            "limits_N": _pair(limits),
            "item": self.plans.item.get(vessel.system),
            "state": vessel.present_state,
            "unknown_mode": vessel.unknown_mode,
            "held": vessel.held(),
            "conditions_lost_s": _round(vessel.conditions_lost_s(), 1),
            "text": vessel.texts.last or None,
            "text_age_s": round(now_s - vessel.texts.said_s, 1) if vessel.texts.last else None,
            "link_age_s": round(max(0.0, now_s - at_s), 2),
            "leader_age_s": _round(value("LEAD_AGE"), 3),
            "battery_V": _round(vessel.aboard.battery_V(at_s), 2),
            "escs": vessel.aboard.escs(at_s),
        }

    # -- poses in the view's frame

    def _pose(self, vessel: Vessel) -> Pose | None:
        place, psi = vessel.motion.place, vessel.motion.psi_rad
        return None if place is None else self._seen(place, psi, vessel.motion.origin)

    def _seen(self, place: Place, psi: float | None, origin: Origin | None) -> Pose | None:
        """Convert a received position to the view's frame; None if impossible."""
        if place.on_globe:
            if self.origin is None:
                return None
            frame = LocalFrame(int(place.x), int(place.y), 0.001 * self.origin[2])
            x, y = 0.0, 0.0
        elif abs(place.x) + abs(place.y) > _FAR_M:
            return None
        elif origin == self.origin:
            return Pose(place.x, place.y, psi)
        elif origin is None or self.origin is None:
            return None
        else:
            frame, x, y = self._frame(origin), place.x, place.y
        north, east, heading = frame.seen_from(self._frame(self.origin), x, y, psi or 0.0)
        return Pose(north, east, None if psi is None else heading)

    def _frame(self, origin: Origin) -> LocalFrame:
        if origin not in self._frames:
            if len(self._frames) > 300:
                self._frames.clear()
            self._frames[origin] = LocalFrame(*origin[:2], 0.001 * origin[2])
        return self._frames[origin]

    def _look_at_origin(self, vessel: Vessel, now_s: float) -> None:
        told = vessel.motion.origin
        if told is None or (self.origin is not None and _apart_m(told, self.origin) < _ELSEWHERE_M):
            return
        others = [v for v in self.systems.values() if now_s - v.heard_s < SILENT_S]
        origins = [v.motion.origin for v in others if v.motion.origin is not None]
        if self.origin is None or all(_apart_m(o, self.origin) > _ELSEWHERE_M for o in origins):
            self.origin = told
            self._slots.clear()
            self.systems = {v.system: v for v in others}

    def _look_at_globe(self, now_s: float) -> None:
        """If nobody sends an origin, use the first global position after some patience."""
        for vessel in self.systems.values():
            place = vessel.motion.place
            waited = now_s - vessel.since_s > _PATIENCE_S and vessel.kind is not None
            if waited and place is not None and place.on_globe:
                self.origin = int(place.x), int(place.y), 0
                return

    # -- slots

    def _anchor_slot(self, vessel: Vessel, now_s: float) -> None:
        """Store a received slot relative to the leader: slots come seldom and move with it."""
        slot, leader = self._told_slot(vessel), self._leader_pose(vessel, now_s)
        self._slots.pop(vessel.system, None)
        if slot is not None and leader is not None:
            self._slots[vessel.system] = slot.x - leader.x, slot.y - leader.y

    def _slot(self, vessel: Vessel, now_s: float) -> tuple[float, float] | None:
        if not vessel.slot_is_told():
            return None
        offset, leader = self._slots.get(vessel.system), self._leader_pose(vessel, now_s)
        if offset is not None and leader is not None:
            return round(leader.x + offset[0], 3), round(leader.y + offset[1], 3)
        slot = self._told_slot(vessel)
        return None if slot is None else (round(slot.x, 3), round(slot.y, 3))

    def _told_slot(self, vessel: Vessel) -> Pose | None:
        motion = vessel.motion
        if motion.slot is None:
            return None
        return self._seen(Place(0.0, False, *motion.slot), None, motion.origin)

    def _leader_pose(self, vessel: Vessel, now_s: float) -> Pose | None:
        number = vessel.value("LEADER")
        leader = None if number is None else self.systems.get(int(number))
        if leader is None or (place := leader.motion.place) is None:
            return None
        return self._pose(leader) if now_s - place.t_s < _CARRIED_S else None


def _apart_m(a: Origin, b: Origin) -> float:
    """Approximate distance of two origins."""
    east = cos(radians(1e-7 * a[0])) * (
        (a[1] - b[1] + 1_800_000_000) % 3_600_000_000 - 1_800_000_000
    )
    return _M_PER_DEGE7 * hypot(a[0] - b[0], east)


def _round(number: float | None, digits: int) -> float | None:
    return None if number is None else round(number, digits)


def _pair(numbers: tuple[float | None, float | None]) -> tuple[float, float] | None:
    first, second = numbers
    return None if first is None or second is None else (round(first, 3), round(second, 3))
