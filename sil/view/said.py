# SPDX-License-Identifier: MIT
"""The boats' messages that a view shows, from a run's recording or from the boats' logs."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from flotilla import kernels
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.lockstep.metrics import PlanEnd
from sil.lockstep.recording import MAVLINK_IN, MAVLINK_OUT, Recording
from sil.plant.hull import Array
from sil.scenario.wiring import HEIGHT_M, WORLD
from sil.view.changes import Changes
from sil.view.history import SIDES, column
from sil.view.seen_plan import Plans, drawn
from sil.view.vessel import Vessel
from sil.wire import mavlink_messages as messages
from sil.wire.geodesy import LocalFrame
from sil.wire.mavlink_ear import Ear
from sil.wire.tlog import of_links

_RADIO = MAVLINK_OUT + 1
# Messages of the boat and of its partners: plans go both ways.
_PLANS = (
    messages.MISSION_CURRENT,
    messages.MISSION_COUNT,
    messages.MISSION_CLEAR_ALL,
    messages.MISSION_ACK,
    messages.MISSION_ITEM_INT,
)
_HEARD = MAVLINK_IN + 1
_SHOWN = (
    messages.HEARTBEAT,
    messages.SYS_STATUS,
    messages.NAMED_VALUE_FLOAT,
    messages.STATUSTEXT,
    messages.ESC_INFO,
    messages.ESC_STATUS,
    *_PLANS,
)

# States in which a boat is out of formation; greatest time by which the reason precedes them, s.
_LOST, _BEFORE_S = ("COAST", "HOLD", "FAULT"), 6.0

_UNKNOWN = 65535  # number of items of a vessel without a plan, in MISSION_CURRENT
_OVER = "Voyage: over"  # begins the text with which a boat ends a voyage

# The NAMED_VALUE_FLOATs that a history needs; nine tenths of all messages are NAMED_VALUE_FLOATs.
_NAMES = {b"COND", b"COND2", b"IN_SLOT", b"LEAD_AGE"}
_ID, _NAME = slice(7, 10), slice(18, 28)
_NAMED_VALUE = messages.NAMED_VALUE_FLOAT.to_bytes(3, "little")


class SaidByBoat:
    """One boat's messages over time; those before the release count as of t_s = 0."""

    def __init__(self, system: int) -> None:
        self.system = system
        self._vessel = Vessel(system, 0.0)
        self.states, self.held, self.texts = Changes(), Changes(), Changes()
        self._severities = Changes()
        self._numbers: dict[str, list[tuple[float, float]]] = {}
        self._seen = Plans(lambda number: number == system)
        self._plans, self._items = Changes(), Changes()
        self._plan: PlanEnd | None = None

    def overhear(self, message: Any, t_s: float) -> None:
        """Process a message of the mission protocol, from or to it."""
        before = self._seen.version
        self._seen.hear(message)
        if self._seen.version != before:
            self._plans.note(t_s, dict(self._seen.of(self.system)))
        self._items.note(t_s, self._seen.item.get(self.system))
        if message.number == messages.MISSION_CURRENT and message.system == self.system:
            self._note_plan(t_s, *message.fields[:3])

    def hear(self, message: Any, t_s: float) -> None:
        """Process one of its messages; `t_s`: time after the release."""
        if message.number in _PLANS:
            self.overhear(message, t_s)
            return
        vessel = self._vessel
        vessel.hear(message, t_s)
        self.states.note(t_s, vessel.present_state)
        self.held.note(t_s, list(vessel.held()))
        self.texts.note(t_s, vessel.texts.last or None)
        self._severities.note(t_s, vessel.severity)
        match message.number:
            case messages.SYS_STATUS:
                self._note("battery_V", t_s, vessel.aboard.battery_V(t_s))
            case messages.NAMED_VALUE_FLOAT:
                self._note("leader_age_s", t_s, vessel.value("LEAD_AGE"))
                self._note("in_slot", t_s, vessel.value("IN_SLOT"))
            case messages.ESC_STATUS | messages.ESC_INFO:
                for side, esc in zip(SIDES, vessel.aboard.escs(t_s), strict=False):
                    for name, number in esc.items():
                        self._note(f"{side}_{name}", t_s, number)

    def is_closing(self) -> bool:
        """Whether it was last in FORMATION but not yet in its slot."""
        return self._vessel.state == "FORMATION" and self._vessel.value("IN_SLOT") == 0.0

    def reasons(self) -> list[str]:
        """Its texts around the time when it first lost FORMATION; empty if it never did."""
        lost = [at_s for at_s, state in self.states.list if at_s > 0.0 and state in _LOST]
        near = (
            text for at_s, text in self.texts.list if lost and -_BEFORE_S < at_s - lost[0] < 1.0
        )
        return list(dict.fromkeys(near))

    def voyage_over(self) -> str:
        """Its text at the end of its voyage; empty before."""
        texts = (text for _, text in self.texts.list if text and text.startswith(_OVER))
        return next(texts, "")

    def plan_end(self) -> PlanEnd | None:
        """How far it came in its plan; None if it had none."""
        return self._plan

    def has_escs(self, port: int, stbd: int) -> None:
        """Set the indices of its propellers' ESCs, 0 and 1 by default."""
        self._vessel.aboard.indices = [port, stbd]

    def told(self, t_s: npt.NDArray[np.floating]) -> dict[str, Any]:
        """Its part of a history: lists of changes, and columns at the times `t_s`."""
        columns: dict[str, Any] = {}
        for name, numbers in self._numbers.items():
            at_s, values = np.array([(-np.inf, np.nan), *numbers]).T
            columns[name] = column(values[np.searchsorted(at_s, t_s, side="right") - 1])
        changes = {"states": self.states, "held": self.held, "texts": self.texts}
        changes["severities"] = self._severities
        plans = [[at_s, drawn(plan, _in_the_world)] for at_s, plan in self._plans.list]
        columns |= {"plans": plans, "items": self._items.list}
        return {**{name: each.list for name, each in changes.items()}, **columns}

    def _note_plan(self, t_s: float, item: int, items: int, state: int) -> None:
        if items in (0, _UNKNOWN):
            self._plan = None
            return
        before_s = self._plan and self._plan["over_s"]
        over = state == mavlink.MISSION_STATE_COMPLETE
        over_s = (t_s if before_s is None else before_s) if over else None
        self._plan = {"item": item + 1, "items": items, "over_s": over_s, "waiting_m": None}

    def _note(self, name: str, t_s: float, number: float | None) -> None:
        if number is not None or name in self._numbers:
            self._numbers.setdefault(name, []).append((t_s, np.nan if number is None else number))


class Said(NamedTuple):
    """The messages of all boats of a run; `parameters`: their firmware's, empty if unknown."""

    boats: list[SaidByBoat]
    parameters: list[dict[str, float]]


def said_in(path: Path, duration_us: float) -> Said:
    """The messages in a recording that ends `duration_us` after the release; ValueError."""
    recording = Recording(path)
    data = np.frombuffer(recording.records, np.uint8)
    wanted = np.zeros(1 << 16, np.bool_)
    wanted[list(_SHOWN)] = True
    found, last_us = kernels.radio_frames(data, _RADIO, wanted)
    of_plans = np.zeros(1 << 16, np.bool_)
    of_plans[list(_PLANS)] = True
    heard, _ = kernels.radio_frames(data, _HEARD, of_plans)
    parameters = [boat["parameters"] for boat in recording.header["boats"]]
    boats = [SaidByBoat(int(own["MAV_SYSID"])) for own in parameters]
    for boat, own in zip(boats, parameters, strict=True):
        boat.has_escs(int(own["ESC_PORT"]), int(own["ESC_STBD"]))
    release_us = last_us - duration_us
    ear = Ear(stream=False)
    for t_us, agent, begin, end in sorted([*found.tolist(), *heard.tolist()]):
        if _is_needed(frame := bytes(recording.records[begin:end])):
            for message in ear.hear(frame):
                boat, t_s = boats[agent - 1], max(0.0, 1e-6 * (t_us - release_us))
                own = message.system == boat.system
                (boat.hear if own else boat.overhear)(message, t_s)
    return Said(boats, parameters)


def said_live(folder: Path, trace: Mapping[str, Array], release_unix_s: float) -> Said:
    """The messages of a live run, from its boats' own logs, as far as they exist.

    Assumes that the propellers' ESCs are 0 and 1, the firmware's default.
    """
    boats = [SaidByBoat(system) for system in range(1, trace["error"].shape[1] + 1)]
    for boat in boats:
        ear = Ear(stream=False)
        for packet in of_links((folder / f"boat{boat.system}" / "log").glob("*.tlog")):
            t_s = 1e-6 * packet.t_us - release_unix_s
            own = packet.system == boat.system
            told = packet.message_id in (_SHOWN if own else _PLANS)
            if told and t_s <= trace["t_s"][-1] and _is_needed(packet.frame):
                for message in ear.hear(packet.frame):
                    (boat.hear if own else boat.overhear)(message, max(0.0, t_s))
    return Said(boats, [])


def _in_the_world(latitude: int, longitude: int) -> tuple[float, float]:
    north, east, _ = LocalFrame(latitude, longitude, HEIGHT_M).seen_from(WORLD, 0.0, 0.0, 0.0)
    return north, east


def _is_needed(frame: bytes) -> bool:
    """Whether a frame is no NAMED_VALUE_FLOAT, or one that a history needs."""
    size = frame[1] - 8  # a payload's zeros at its end are not sent
    return frame[_ID] != _NAMED_VALUE or frame[_NAME][:size].rstrip(b"\0") in _NAMES
