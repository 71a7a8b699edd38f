# SPDX-License-Identifier: MIT
"""A ground station: hears boats on several links, and sends to one boat or to all.

Its heartbeat is not of type GCS: boats that stop without a ground station (`FS_GCS_S`) must not
rely on a command that ends after a few seconds.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.fleet.ends import Clock, End, Peer, RealTime
from sil.fleet.heard_tables import HeardTables
from sil.view.seen_fleet import Fleet
from sil.wire import mavlink_messages as messages
from sil.wire.fleet_table import Beacon, HeardTable, beacon_of
from sil.wire.heartbeat import AUTO, FORMATION, GUIDED, HOLD, LOITER, MANUAL, RTL
from sil.wire.mavlink_ear import Ear, Message
from sil.wire.mavlink_frames import frames
from sil.wire.signing import Signer, is_signed, numbered

SYSTEM, COMPONENT, LINK = 255, mavlink.MAV_COMP_ID_USER1, 70
STALE_S = 5.0

_BEAT_S, _SLICE_S, _AGAIN_S = 1.0, 0.05, 1.0
_ROUTE_S = 10.0
_ASK_S = 0.3
_COMPANION: int = mavlink.MAV_COMP_ID_ONBOARD_COMPUTER
_AUTOPILOTS = (mavlink.MAV_COMP_ID_AUTOPILOT1, _COMPANION)
_MODES = (MANUAL, HOLD, LOITER, FORMATION, AUTO, RTL, GUIDED)
_MOST_KEPT = 1000  # acknowledgements and texts; a command hears a few dozen


class Ack(NamedTuple):
    """A boat's answer to a command of this station."""

    at_s: float
    system: int
    command: int
    result: int


class Shown(NamedTuple):
    """The state in a HEARTBEAT; a vessel that is not known as a boat is read like one."""

    at_s: float
    state: str | None


class Text(NamedTuple):
    """A STATUSTEXT."""

    at_s: float
    system: int
    text: str


class Station:
    """One station at `ends`, with system id `system`; with a `signer`, it accepts only its key.

    `fleet`: the vessels heard. `shown`: the last state of each, however old. `signs`: system ids of
    those that sign, where the station has no key. `parameters`: by system id and name. `aliases`:
    more system ids of this program, whose messages are ignored; `echoed`: the numbers of such
    messages. `refused`: number of messages without a good signature; `late_s`: age of those of
    boats whose key is good. Times are s since the station began. `kind`: its heartbeat's MAV_TYPE.
    `meanwhile` is called at least 20 times a second while it listens, `told` about lost links.
    """

    def __init__(
        self,
        ends: Sequence[End],
        system: int = SYSTEM,
        signer: Signer | None = None,
        clock: Clock | None = None,
    ) -> None:
        self.system = system
        self.fleet = Fleet(length_m=1.0)
        self.shown: dict[int, Shown] = {}
        self.parameters: dict[tuple[int, str], float] = {}
        self.acks: list[Ack] = []
        self.texts: list[Text] = []
        self.signs: set[int] = set()
        self.refused = 0
        self.late_s: dict[int, float] = {}
        self.aliases: set[int] = set()
        self.echoed: set[int] = set()
        self.kind: int = mavlink.MAV_TYPE_ONBOARD_CONTROLLER
        self.meanwhile: Callable[[], None] = lambda: None
        self.told: Callable[[str], None] = lambda _: None
        self._ends = list(ends)
        self._lost: dict[End, float] = {}  # until heard again; when to open it next
        self._signer = signer
        self._ear = Ear(stream=False)
        self._mav = mavlink.MAVLink(None, system, COMPONENT)
        self._clock = clock or RealTime()
        self._began_s = self._clock.now_s()
        # Boats take messages with equal numbers on two links for copies, so each command begins
        # with another number.
        self._sequence = int(1000.0 * self._began_s)
        self._autopilots: dict[int, set[int]] = {}  # components that a boat's heartbeat came from
        self._surface_boats: set[int] = set()  # ours and others
        self._beacons: dict[tuple[int, int], tuple[float, Beacon]] = {}
        self._tables = HeardTables()
        self._routes: dict[int, dict[tuple[End, Peer], float]] = {}
        self._asked_s: dict[int, float] = {}
        self._beat_s = 0.0

    def now_s(self) -> float:
        """The station's time."""
        return self._clock.now_s() - self._began_s

    def unix_s(self) -> float:
        """The date and time of day, s since 1970 (UTC)."""
        return self._clock.unix_s()

    def boats(self) -> list[int]:
        """System ids of the Flotilla boats: those whose autopilot's heartbeat was ever heard."""
        return sorted(self._autopilots.keys())

    def component(self, system: int) -> int:
        """The component that obeys orders to a boat: 191 if it is an autopilot's companion."""
        return max(self._autopilots.get(system, ()), default=mavlink.MAV_COMP_ID_AUTOPILOT1)

    def strangers(self) -> list[int]:
        """Surface boats that are heard at present, and have not said that they run Flotilla."""
        return sorted(filter(self.is_heard, self._surface_boats - self._autopilots.keys()))

    def is_heard(self, system: int) -> bool:
        """Whether a system is heard at present."""
        vessel = self.fleet.systems.get(system)
        return vessel is not None and self.now_s() - vessel.heard_s < STALE_S

    def beacon(self, system: int) -> Beacon | None:
        """A boat's last beacon; None if it has sent none or it is old."""
        at_s, beacon = self._last_beacon(system)
        return beacon if self.now_s() - at_s < STALE_S else None

    def last_beacon(self, system: int) -> Beacon | None:
        """The same, however old it is."""
        return self._last_beacon(system)[1]

    def say(self, message: mavlink.MAVLink_message, system: int | None = None) -> None:
        """Send a message on the links where a system was heard; None: on all links."""
        self.send(message.pack(self._mav), system)

    def send(self, frame: bytes, system: int | None = None) -> None:
        """The same as `say`, for an unsigned frame, which gets its number and signature here."""
        self._sequence = (self._sequence + 1) & 0xFF
        whole = numbered(frame, self._sequence)
        if self._signer is not None:
            whole = self._signer.sign(whole)
        since_s = self.now_s() - _ROUTE_S
        known = self._routes.get(system, {}) if system is not None else {}
        routes = [route for route, at_s in known.items() if at_s > since_s]
        for end, peer in routes or [(end, None) for end in self._ends]:
            end.send(whole, peer)

    def run(self, for_s: float, done: Callable[[], object] = lambda: False) -> bool:
        """Listen for `for_s`, or until `done` returns true; return whether it did."""
        end_s = self.now_s() + for_s
        while not done():
            left_s = end_s - self.now_s()
            if left_s <= 0.0:
                return False
            self._listen(min(left_s, _SLICE_S))
        return True

    def close(self) -> None:
        """Close all ends."""
        for end in self._ends:
            end.close()

    def whole_table(self, epoch: int, digest: int) -> HeardTable | None:
        """The table that boats report by this epoch and digest; None if none has passed it on."""
        return self._tables.whole(epoch, digest)

    def table(self) -> HeardTable:
        """The members of all tables that this station has heard boats pass on."""
        known = self._autopilots.items()
        return self._tables.of({(system, each) for system, all_ in known for each in all_})

    def _last_beacon(self, system: int) -> tuple[float, Beacon | None]:
        """The last beacon and its time, from a component that has sent a boat's heartbeat."""
        components = self._autopilots.get(system, set())
        told = [
            self._beacons[key] for each in components if (key := (system, each)) in self._beacons
        ]
        return max(told, key=lambda one: one[0], default=(-STALE_S, None))

    def _listen(self, wait_s: float) -> None:
        if self.now_s() >= self._beat_s:
            self._beat_s = self.now_s() + _BEAT_S
            none, state = mavlink.MAV_AUTOPILOT_INVALID, mavlink.MAV_STATE_ACTIVE
            self.say(mavlink.MAVLink_heartbeat_message(self.kind, none, 0, 0, state, 3))
        self._open_again()
        for end in self._clock.wait(self._ends, wait_s):
            try:
                heard = end.receive()
            except OSError:
                self._lose(end)
                continue
            if heard and self._lost.pop(end, None) is not None:
                self.told(f"{end.address}: connected again")
            for peer, data in heard:
                self._hear(end, peer, data)
        self.meanwhile()

    def _lose(self, end: End) -> None:
        """Close an end, to open it again each second; OSError if no other one is left."""
        self._ends.remove(end)
        end.close()
        for known in self._routes.values():
            for route in [route for route in known if route[0] is end]:
                del known[route]
        ended = f"{end.address}: the other side has ended the connection"
        if end not in self._lost:
            self.told(f"{ended}; trying again")
        self._lost[end] = self.now_s() + _AGAIN_S
        if self._lost.keys() >= {*self._ends}:
            raise OSError(ended)

    def _open_again(self) -> None:
        for end, at_s in self._lost.items():
            if self.now_s() >= at_s:
                self._lost[end] = self.now_s() + _AGAIN_S
                with suppress(OSError):
                    end.reopen()
                    self._ends.append(end)
                    self._lost[end] = math.inf

    def _hear(self, end: End, peer: Peer, data: bytes) -> None:
        if self._signer is None:
            self.signs |= {system for _, system, _, frame in frames(data) if is_signed(frame)}
        else:
            data = b"".join(self._verified(data, self._signer))
        self._tables.hear(data)
        for message in self._ear.hear(data):
            if message.fields is not None and message.system in self.aliases:
                self.echoed.add(message.number)
            elif message.fields is not None and message.system != self.system:
                now_s = self.now_s()
                self._routes.setdefault(message.system, {})[end, peer] = now_s
                self._take(message, now_s)

    def _verified(self, data: bytes, signer: Signer) -> Iterator[bytes]:
        """Yield the frames with a good signature."""
        for number, system, component, frame in frames(data):
            if signer.verifies(frame):
                self.late_s.pop(system, None)
                yield frame
                continue
            self.refused += 1
            late_s = signer.late_s(frame)
            is_beat = number == messages.HEARTBEAT and component in _AUTOPILOTS
            if late_s is not None and is_beat and system != self.system:
                self.late_s[system] = late_s

    def _take(self, message: Message, now_s: float) -> None:
        number, system, component, fields = message
        self.fleet.hear([message], now_s)
        self._identify(system, component, now_s)
        if not fields:
            return
        if number == messages.HEARTBEAT:
            self._look_at_heartbeat(system, component, fields)
        elif number == messages.FLEET_BEACON:
            self._beacons[system, component] = now_s, beacon_of(fields)
        elif number == messages.COMMAND_ACK:
            command, result, _, _, to_system, to_component = fields
            if (to_system, to_component) == (self.system, COMPONENT):
                self.acks = [*self.acks[-_MOST_KEPT:], Ack(now_s, system, command, result)]
        elif number == messages.PARAM_VALUE:
            name = fields[3].split(b"\0")[0].decode("ascii", "replace")
            self.parameters[system, name] = fields[0]
        elif number == messages.STATUSTEXT:
            said = self.fleet.systems[system].texts
            if said.said_s == now_s and said.last:
                self.texts = [*self.texts[-_MOST_KEPT:], Text(now_s, system, said.last)]

    def _look_at_heartbeat(self, system: int, component: int, fields: tuple[Any, ...]) -> None:
        """Record the state, and the component that sends it: a boat's autopilot, or a companion."""
        vessel = self.fleet.systems[system]
        if vessel.kind is not None:
            self.shown[system] = Shown(vessel.beat_s, vessel.shown)
        mode, kind, autopilot = fields[:3]
        is_none = autopilot == mavlink.MAV_AUTOPILOT_INVALID
        if kind == mavlink.MAV_TYPE_SURFACE_BOAT and not is_none:
            self._surface_boats.add(system)
        is_boat = vessel.kind == "boat" and mode in _MODES
        if is_boat and (component == _COMPANION or not is_none):
            self._autopilots.setdefault(system, set()).add(component)

    def _identify(self, system: int, component: int, now_s: float) -> None:
        """Request a HEARTBEAT of an unidentified system: it comes only once a second."""
        vessel = self.fleet.systems.get(system)
        if vessel is None or vessel.kind is not None or component not in _AUTOPILOTS:
            return
        if now_s < self._asked_s.get(system, 0.0):
            return
        self._asked_s[system] = now_s + _ASK_S
        request, heartbeat = mavlink.MAV_CMD_REQUEST_MESSAGE, float(messages.HEARTBEAT)
        self.say(
            mavlink.MAVLink_command_long_message(
                system, component, request, 0, heartbeat, 0, 0, 0, 0, 0, 0
            ),
            system,
        )
