# SPDX-License-Identifier: MIT
"""The whole fleet as one MAVLink vehicle: a ground station commands it like one boat.

Arming, HOLD and a stop go to every boat directly. AUTO, LOITER, RTL and a destination go to the
leader; boats in HOLD then follow. The fleet vehicle reports the leader's position and mode. It is
armed as long as any boat is armed, or was when it fell silent.
"""

import io
from collections import deque
from collections.abc import Callable
from functools import partial
from math import cos, degrees, sin
from typing import NamedTuple

from pymavlink.dialects.v20 import ardupilotmega as mavlink
from rich.console import Console

from sil.fleet.actions import Wish, perform, place_of
from sil.fleet.ends import End
from sil.fleet.fleet_status import verdict_of
from sil.fleet.lead import root
from sil.fleet.orders import DISCOVERY_S
from sil.fleet.station import Station
from sil.fleet.vehicle_commands import KNOWN, wish_of
from sil.wire import mavlink_messages as messages
from sil.wire.heartbeat import AUTO, FORMATION, GUIDED, HOLD, LOITER, MANUAL, RTL
from sil.wire.mavlink_frames import frames
from sil.wire.signing import Signer

SYSTEM, LINK = 250, 71

_BEAT_S, _POSITION_S, _VERDICT_S = 1.0, 0.5, 5.0
_STATION_SILENT_S = 3.0
_TEXT_BYTES = 50
_ARMED_MODE = mavlink.MAV_MODE_FLAG_SAFETY_ARMED
_CUSTOM = mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
_NUMBERS = {
    "MANUAL": MANUAL,
    "HOLD": HOLD,
    "LOITER": LOITER,
    "FORMATION": FORMATION,
    "COAST": FORMATION,
    "AUTO": AUTO,
    "RTL": RTL,
    "GUIDED": GUIDED,
}
_OF_LEADER = ("auto", "loiter", "return", "go")
_STOPS = {"stop": 2, "hold": 1}  # the greater one cancels the others
_UNKNOWN_HEADING = 65535
_SAID = {  # by this vehicle: a router may send these back
    messages.HEARTBEAT,
    messages.PARAM_VALUE,
    messages.GLOBAL_POSITION_INT,
    messages.MISSION_COUNT,
    messages.COMMAND_ACK,
    messages.STATUSTEXT,
}
_CANCELLED = 6  # MAV_RESULT_CANCELLED, which pymavlink lacks


class SupersededError(Exception):
    """A command arrived that stops the boats."""


class Command(NamedTuple):
    """A request and its sender.

    `number`: the MAVLink command; None for SET_MODE, which has no answer.
    """

    number: int | None
    system: int
    component: int
    wish: Wish


class FleetVehicle:
    """One vehicle with system id `system` at a ground station's `end`, for the boats of `station`.

    With a `signer` the ground station must sign, too. Commands are executed one after another; a
    stop and HOLD cancel all others at once. `told` is called with a text about each action.
    """

    def __init__(
        self,
        station: Station,
        end: End,
        system: int = SYSTEM,
        signer: Signer | None = None,
        told: Callable[[str], None] = lambda _: None,
    ) -> None:
        self._station = station
        self._end = end
        self._signer = signer
        self._told = told
        self._mav = mavlink.MAVLink(None, system, mavlink.MAV_COMP_ID_AUTOPILOT1)
        self._ear = mavlink.MAVLink(None)
        self._ear.robust_parsing = True
        self._leader: int | None = None  # the last known leader
        self._asked: deque[Command] = deque()
        self._carried_out: Command | None = None
        self._beat_s = self._position_s = 0.0
        self._verdict_s = DISCOVERY_S
        self._station_s = -_STATION_SILENT_S
        self._verdict = ""
        self._chunked = 0
        self._has_warned = False
        station.aliases.add(system)
        station.meanwhile = self._attend
        station.told = partial(self._text, warns=True)

    def serve(self, for_s: float) -> None:
        """Act as this vehicle for `for_s` seconds.

        OSError if an end has ended; ValueError if a boat has the vehicle's id when the station
        begins. Later, and for echoes, there is a warning, and such messages are ignored.
        """
        end_s = self._station.now_s() + for_s
        while (left_s := end_s - self._station.now_s()) > 0.0:
            if self._station.run(left_s, lambda: self._asked):
                self._carried_out = self._asked.popleft()
                try:
                    self._answer(self._carried_out, self._obey(self._carried_out.wish))
                except SupersededError:
                    self._answer(self._carried_out, _CANCELLED)
                finally:
                    self._carried_out = None

    def _obey(self, wish: Wish) -> int:
        if wish.action in _OF_LEADER and self._leader is not None:
            wish = wish._replace(boats=(self._leader,))
        status = self._perform(wish)
        if status == 0 and wish.action in _OF_LEADER and (resting := self._resting()):
            status = self._perform(Wish("follow", boats=resting))
        result: int = mavlink.MAV_RESULT_FAILED if status else mavlink.MAV_RESULT_ACCEPTED
        return result

    def _perform(self, wish: Wish) -> int:
        words = io.StringIO()
        try:
            status = perform(self._station, wish, Console(file=words, width=200, highlight=False))
        except ValueError as error:
            words.write(str(error))
            status = 1
        for line in words.getvalue().splitlines():
            self._text(line.strip(), warns=status != 0)
        return status

    def _resting(self) -> tuple[int, ...]:
        """The boats in HOLD."""
        station = self._station
        return tuple(
            boat
            for boat in station.boats()
            if station.is_heard(boat) and station.fleet.systems[boat].state == "HOLD"
        )

    def _attend(self) -> None:
        """Receive from the ground station and report the fleet to it, in every state."""
        for _, data in self._end.receive():
            for *_, frame in frames(data):
                if self._signer is None or self._signer.verifies(frame):
                    for message in self._ear.parse_buffer(frame) or ():
                        self._take(message)
        now_s = self._station.now_s()
        if (top := root(self._station)) in self._station.boats():
            self._leader = top
        hears = now_s - self._station_s < _STATION_SILENT_S
        # Boats that stop without a ground station must notice that the real one is missing.
        self._station.kind = mavlink.MAV_TYPE_GCS if hears else mavlink.MAV_TYPE_ONBOARD_CONTROLLER
        if now_s >= self._beat_s:
            self._beat_s = now_s + _BEAT_S
            self._look_at_echoes(now_s)
            self._say(self._heartbeat())
        if now_s >= self._position_s:
            self._position_s = now_s + _POSITION_S
            if (position := self._position()) is not None:
                self._say(position)
        if now_s >= self._verdict_s:
            self._verdict_s = now_s + _VERDICT_S
            verdict = verdict_of(self._station, self._station.boats())
            if verdict != self._verdict:
                self._verdict = verdict
                self._text(verdict, warns=False)
        first, now = self._asked[0] if self._asked else None, self._carried_out
        if first and now and _rank(first) > _rank(now):
            raise SupersededError

    def _look_at_echoes(self, now_s: float) -> None:
        """Warn of messages with the vehicle's id among the boats; ValueError if a boat has it."""
        own, echoed = self._mav.srcSystem, self._station.echoed
        if now_s < DISCOVERY_S and echoed - _SAID:
            raise ValueError(f"a vessel already has system id {own}: choose another with --as")
        if echoed and not self._has_warned:
            self._has_warned = True
            which = f"messages with system id {own} among the boats are ignored"
            self._text(f"{which}: if a boat has it, choose another with --as", warns=True)

    def _take(self, message: mavlink.MAVLink_message) -> None:
        kind, own = message.get_type(), self._mav.srcSystem
        if message.get_srcSystem() == own or getattr(message, "target_system", own) not in (0, own):
            return
        if kind == "HEARTBEAT":
            if message.type == mavlink.MAV_TYPE_GCS:
                self._station_s = self._station.now_s()
        elif kind == "PARAM_REQUEST_LIST":
            count = float(len(self._station.boats()))
            real = mavlink.MAV_PARAM_TYPE_REAL32
            self._say(mavlink.MAVLink_param_value_message(b"FLEET_BOATS", count, real, 1, 0))
        elif kind == "MISSION_REQUEST_LIST":
            to = message.get_srcSystem(), message.get_srcComponent()
            self._say(mavlink.MAVLink_mission_count_message(*to, 0, message.mission_type))
        elif kind in ("COMMAND_LONG", "COMMAND_INT", "SET_MODE"):
            self._ask(message)

    def _ask(self, message: mavlink.MAVLink_message) -> None:
        wish = wish_of(message)
        number = None if message.get_type() == "SET_MODE" else message.command
        asker = number, message.get_srcSystem(), message.get_srcComponent()
        if wish is None:
            known = number is None or number in KNOWN
            refused = mavlink.MAV_RESULT_DENIED if known else mavlink.MAV_RESULT_UNSUPPORTED
            self._answer(Command(*asker, Wish("")), refused)
            return
        command = Command(*asker, wish)
        self._answer(command, mavlink.MAV_RESULT_IN_PROGRESS)
        for other in [other for other in self._asked if _rank(other) < _rank(command)]:
            self._asked.remove(other)
            self._answer(other, _CANCELLED)
        if command in (self._carried_out, *self._asked):
            return
        self._asked.append(command)

    def _heartbeat(self) -> mavlink.MAVLink_message:
        station, boats = self._station, self._station.boats()
        # The last known states: a boat that is silent may still be armed.
        states = {boat: station.shown[boat].state for boat in boats}
        mode = _NUMBERS.get(states.get(self._leader or 0) or "", HOLD)
        armed = any(state not in (None, "DISARMED") for state in states.values())
        well = states and all(map(station.is_heard, boats)) and "FAULT" not in states.values()
        return mavlink.MAVLink_heartbeat_message(
            mavlink.MAV_TYPE_SURFACE_BOAT,
            mavlink.MAV_AUTOPILOT_GENERIC,
            _CUSTOM | (_ARMED_MODE if armed else 0),
            mode,
            mavlink.MAV_STATE_ACTIVE if well else mavlink.MAV_STATE_CRITICAL,
            3,
        )

    def _position(self) -> mavlink.MAVLink_message | None:
        """The leader's position; None if it is unknown."""
        try:
            latitude, longitude = place_of(self._station, self._leader or 0, (0.0, 0.0))
        except ValueError:
            return None
        told = self._station.fleet.vessels(self._station.now_s())
        vessel = next(vessel for vessel in told if vessel["id"] == self._leader)
        heading = vessel["psi_rad"]
        psi, u, v = heading or 0.0, vessel["u_mps"] or 0.0, vessel["v_mps"] or 0.0
        north, east = u * cos(psi) - v * sin(psi), u * sin(psi) + v * cos(psi)
        return mavlink.MAVLink_global_position_int_message(
            round(1000.0 * self._station.now_s()) & 0xFFFFFFFF,
            round(1e7 * latitude),
            round(1e7 * longitude),
            *(0, 0),
            *(_int16(100.0 * north), _int16(100.0 * east), 0),
            _UNKNOWN_HEADING if heading is None else round(100.0 * degrees(psi)) % 36000,
        )

    def _answer(self, command: Command, result: int) -> None:
        if command.number is not None:
            to = command.system, command.component
            self._say(mavlink.MAVLink_command_ack_message(command.number, result, 0, 0, *to))

    def _text(self, text: str, *, warns: bool) -> None:
        """Send a STATUSTEXT, in as many parts as it needs."""
        if not text:
            return
        self._told(text)
        level = mavlink.MAV_SEVERITY_WARNING if warns else mavlink.MAV_SEVERITY_INFO
        whole = text.encode("ascii", "replace")
        self._chunked = self._chunked % 0xFFFF + 1
        number = self._chunked if len(whole) > _TEXT_BYTES else 0
        for part, begin in enumerate(range(0, len(whole), _TEXT_BYTES)):
            piece = whole[begin : begin + _TEXT_BYTES]
            self._say(mavlink.MAVLink_statustext_message(level, piece, number, part))

    def _say(self, message: mavlink.MAVLink_message) -> None:
        frame = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) & 0xFF
        self._end.send(frame if self._signer is None else self._signer.sign(frame), None)


def _rank(command: Command) -> int:
    return _STOPS.get(command.wish.action, 0)


def _int16(value: float) -> int:
    return max(-32767, min(32767, round(value)))
