# SPDX-License-Identifier: MIT
"""One MAVLink system: whether it is a vessel, its kind, and its last telemetry."""

from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.view import states
from sil.view.aboard import Aboard
from sil.view.clocks import Clocks
from sil.view.seen_motion import Motion
from sil.wire import mavlink_messages as messages
from sil.wire.heartbeat import state_of
from sil.wire.mavlink_ear import Message
from sil.wire.texts import Texts

_SLOW_S = 5.0
_CONDITIONS = "COND", "COND2"
_AUTOPILOT: int = mavlink.MAV_COMP_ID_AUTOPILOT1
_COMPANION: int = mavlink.MAV_COMP_ID_ONBOARD_COMPUTER
_NO_VESSELS = {mavlink.MAV_TYPE_GCS, mavlink.MAV_TYPE_ADSB, mavlink.MAV_TYPE_ONBOARD_CONTROLLER}
# Sent by no other firmware; DEPTH is not, since others use that name for an echo sounder.
_OUR_MESSAGES = {messages.FORMATION_REFERENCE, messages.FORMATION_FUTURE, messages.FLEET_BEACON}
_OUR_VALUES = {b"COND", b"SEP_M"}


class Vessel:
    """A system that may be a vessel; `kind` is None until a HEARTBEAT identifies it as one.

    kind: "boat" (a Flotilla), "leader" (virtual: GENERIC), "vessel" (another vehicle). A component
    that has once sent a message that only Flotilla sends stays a boat. Its position is taken from
    component 1, else from the lowest component heard; times are the listener's, s.
    """

    def __init__(self, system: int, now_s: float) -> None:
        self.system = system
        self.since_s = now_s
        self.messages = 0
        self.heard_s = self.beat_s = 0.0
        self.kind: str | None = None
        self.state: str | None = None  # in its last HEARTBEAT
        self.shown: str | None = None  # the state of a boat with that HEARTBEAT
        self.texts = Texts()
        self.severity: int | None = None  # of the last text, MAV_SEVERITY
        self.motion = Motion()
        self.aboard = Aboard()
        self._mode: int | None = None  # custom_mode of a boat's HEARTBEAT without a known state
        self._main = 256
        self._ours: set[int] = set()  # components that run Flotilla
        self._clocks = Clocks()
        self._anew: tuple[Motion, Aboard] | None = None  # values from a sender with another clock

    def hear(self, message: Message, now_s: float) -> None:
        """Process a message of this system."""
        number, _, component, fields = message
        self.messages += 1
        self.heard_s = now_s
        if component != self._main and (component == _AUTOPILOT or component < self._main != 1):
            self._main = component
        if component not in self._ours and _is_ours(number, fields):
            self._ours.add(component)
        if not fields:
            return
        if number == messages.HEARTBEAT:
            self._beat(component, fields, now_s)
        elif number == messages.STATUSTEXT:
            severity, piece, text, chunk = fields
            before = self.texts.last
            self.texts.hear(component, piece, text, chunk, now_s)
            if self.texts.last != before:
                self.severity = severity
        elif component == self._main:
            if number == messages.ATTITUDE:
                self._look_at_clock(fields[0], now_s)
            for part in (self.motion, self.aboard, *(self._anew or ())):
                part.hear(number, fields, now_s)
        elif component == _COMPANION:
            self.aboard.hear(number, fields, now_s)

    @property
    def present_state(self) -> str | None:
        """A boat's state; None if its last HEARTBEAT was 5 s before its last message."""
        return self.state if self._beats() else None

    @property
    def unknown_mode(self) -> int | None:
        """The custom_mode that makes a boat's state unknown, while its HEARTBEAT is heard."""
        return self._mode if self._beats() else None

    def _beats(self) -> bool:
        return self.heard_s - self.beat_s <= _SLOW_S

    def value(self, name: str) -> float | None:
        """A NAMED_VALUE_FLOAT that was still valid at the vessel's last message."""
        return self.aboard.value(name, self.heard_s)

    def slot_is_told(self) -> bool:
        """Whether its slot was still valid at the vessel's last message."""
        motion = self.motion
        return motion.slot is not None and self.heard_s <= motion.slot_valid.until_s

    def held(self) -> tuple[str, ...]:
        """The boat's messages for the conditions that keep it out of FORMATION."""
        told = [self.value(name) for name in _CONDITIONS]
        halves = [int(half) for half in told if half is not None and 0 <= half < 1 << 24]
        if self.state is None or len(halves) < len(told):
            return ()
        return states.held_by(halves[0] | halves[1] << 24, self.state)

    def conditions_lost_s(self) -> float | None:
        """Age of its conditions if they are no longer valid, s; else None."""
        lost = [self.aboard.lost_s(name, self.heard_s) for name in _CONDITIONS]
        return max((age_s for age_s in lost if age_s is not None), default=None)

    def senders(self) -> int | None:
        """2 if two vessels use its system id; else None."""
        return 2 if self._clocks.are_two(self.heard_s) else None

    def _beat(self, component: int, f: tuple[Any, ...], now_s: float) -> None:
        custom_mode, kind, autopilot, base_mode, status = f[:5]
        if _COMPANION in self._ours:  # beside another autopilot
            if component != _COMPANION:
                return
            self.kind = "boat"
        elif component != self._main:
            return
        elif kind in _NO_VESSELS:
            self.kind = None
        elif kind == mavlink.MAV_TYPE_GENERIC:
            self.kind = "leader" if component == _AUTOPILOT else None
        elif autopilot == mavlink.MAV_AUTOPILOT_INVALID:
            self.kind = None
        else:
            ours = autopilot == mavlink.MAV_AUTOPILOT_GENERIC or (
                autopilot == mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA  # MAV_AUTOPILOT 1
                and component in self._ours
            )
            ours = ours and kind == mavlink.MAV_TYPE_SURFACE_BOAT
            self.kind = "boat" if ours else "vessel"
        self.beat_s = now_s
        is_boat = self.kind == "boat"
        self.shown = state_of(custom_mode, base_mode, status)
        self.state = self.shown if is_boat else None
        self._mode = custom_mode if is_boat and self.state is None else None

    def _look_at_clock(self, boot_ms: int, now_s: float) -> None:
        """Drop all values from before a restart of the vessel."""
        if self._clocks.hear(boot_ms, now_s) and self._anew is not None:
            self.motion, self.aboard = self._anew
        if self._clocks.strange == 0:
            self._anew = None
        elif self._clocks.strange == 1:
            self._anew = Motion(), Aboard()


def _is_ours(number: int, fields: tuple[Any, ...] | None) -> bool:
    """Whether only a Flotilla sends this message."""
    if number == messages.NAMED_VALUE_FLOAT and fields:
        return fields[2].split(b"\0")[0] in _OUR_VALUES
    return number in _OUR_MESSAGES and fields is not None
