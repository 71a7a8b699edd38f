# SPDX-License-Identifier: MIT
"""The history of a tlog: the view that a live page would have shown."""

from collections.abc import Callable, Iterable, Iterator
from math import nan
from pathlib import Path
from typing import Any

import numpy as np

from sil.view.aboard import ESC_NUMBERS
from sil.view.changes import Changes
from sil.view.history import COLUMNS, LENGTH_M, SIDES, column, most_samples
from sil.view.seen_fleet import FORGOTTEN_S, Fleet
from sil.view.vessel import Vessel
from sil.wire import mavlink_messages as messages
from sil.wire.mavlink_ear import Ear, Message
from sil.wire.tlog import Packet, of_links

_LONGEST_GAP_S = 3600.0
_FIRST_STEP_S = 0.1
_MOMENT_S = 0.001
# Columns whose values the frame has under another name.
_PLACES = {
    "slot_x_m": ("slot", 0),
    "slot_y_m": ("slot", 1),
    "thrust_port_N": ("thrust_N", 0),
    "thrust_stbd_N": ("thrust_N", 1),
}
_ESCS = {f"{s}_{name}": (side, name) for side, s in enumerate(SIDES) for name in ESC_NUMBERS}
_NOTHING = [nan] * len(COLUMNS)
_FORGOTTEN = [FORGOTTEN_S if name == "link_age_s" else nan for name in COLUMNS]
Told = dict[str, Any]


def history_of_tlog(path: Path, length_m: float = LENGTH_M) -> dict[str, Any]:
    """The history of a tlog, or of a folder with a boat's, one for each link.

    `length_m`: of its boats. ValueError if there is no message.

    If time stamps step back, or ahead by more than an hour, the clock was set: no time passes.
    """
    watch = Watch(Fleet(length_m))
    tlogs = sorted(path.glob("*.tlog")) if path.is_dir() else [path]
    for t_s, message in messages_of(of_links(tlogs)):
        watch.hear(t_s, message)
    if not watch.times:
        raise ValueError(f"{path} is not a tlog: it contains no MAVLink message")
    return watch.history(path.name)


class Watch:
    """Samples a fleet at equal intervals; doubles the interval when the samples get too many."""

    def __init__(self, fleet: Fleet) -> None:
        self.times: list[float] = []
        self._last_s = 0.0
        self._step_s = _FIRST_STEP_S
        self._fleet = fleet
        self._told: dict[int, _Told] = {}
        self._version = 0

    def hear(self, t_s: float, message: Message) -> None:
        """Process a message that arrived at `t_s`."""
        self.wait(t_s)
        self._last_s = t_s
        self._fleet.hear([message], t_s)
        if message.number in (messages.HEARTBEAT, messages.STATUSTEXT, messages.NAMED_VALUE_FLOAT):
            vessel = self._fleet.systems.get(message.system)
            if vessel is not None and vessel.kind is not None:
                self._told.setdefault(vessel.system, _Told()).note(t_s, vessel)
        self._note_plans(t_s, message)

    def _note_plans(self, t_s: float, message: Message) -> None:
        plans = self._fleet.plans
        if plans.version != self._version:
            self._version = plans.version
            for system in plans.systems():
                self._told.setdefault(system, _Told()).plans.note(t_s, dict(plans.of(system)))
        if message.number == messages.MISSION_CURRENT and message.system in self._told:
            self._told[message.system].items.note(t_s, plans.item.get(message.system))

    def wait(self, t_s: float) -> None:
        """Sample up to `t_s`, with no message in between."""
        while len(self.times) * self._step_s <= t_s:
            self._look(len(self.times) * self._step_s)

    def history(self, title: str) -> Told:
        """The history so far, ending with the vessels' last values; changes nothing."""
        samples = len(self.times)
        self._sample(max([self._last_s, *(t_s + _MOMENT_S for t_s in self.times[-1:])]))
        told = self._history(title)
        del self.times[samples:]
        for vessel in self._told.values():
            vessel.keep(samples)
        return told

    def _history(self, title: str) -> Told:
        return {
            "title": title,
            "origin_deg": self._fleet.origin_deg,
            "t_s": column(self.times),
            "vessels": [
                told.history(len(self.times), self._fleet.drawn)
                for _, told in sorted(self._told.items())
                if told.last
            ],
        }

    def _look(self, t_s: float) -> None:
        self._sample(t_s)
        if len(self.times) >= most_samples(max(1, len(self._told))):
            self._step_s *= 2.0
            for told in self._told.values():
                told.halve(len(self.times))
            self.times = self.times[::2]

    def _sample(self, t_s: float) -> None:
        for vessel in self._fleet.vessels(t_s):
            self._told.setdefault(vessel["id"], _Told()).look(len(self.times), t_s, vessel)
        self.times.append(t_s)


class _Told:
    """One vessel's values over time."""

    def __init__(self) -> None:
        self.last: Told = {}
        self._rows: list[list[float]] = []
        self._leader: int | None = None
        self._limits_N: tuple[float, float] | None = None
        self._states, self._held = Changes(), Changes()
        self._texts, self._severities = Changes(), Changes()
        self.plans, self.items = Changes(), Changes()

    def look(self, index: int, t_s: float, vessel: Told) -> None:
        """Add the sample with this index."""
        self._fill(index)
        self._states.note(t_s, vessel["state"])
        self._rows.append([_number(vessel, name) for name in COLUMNS])
        self.last = vessel
        self._leader = self._leader if vessel["leader"] is None else vessel["leader"]
        self._limits_N = vessel["limits_N"] or self._limits_N

    def note(self, t_s: float, vessel: Vessel) -> None:
        """Note its state, missing conditions and text."""
        self._states.note(t_s, vessel.present_state)
        self._held.note(t_s, list(vessel.held()))
        self._texts.note(t_s, vessel.texts.last or None)
        self._severities.note(t_s, vessel.severity)

    def keep(self, samples: int) -> None:
        """Drop all but the first samples."""
        del self._rows[samples:]

    def halve(self, samples: int) -> None:
        """Drop every other one of `samples` samples."""
        self._fill(samples)
        self._rows = self._rows[::2]

    def history(self, samples: int, draw: Callable[[Any], Told]) -> Told:
        """The vessel's entry in a history of `samples` samples; `draw`: a plan for the page."""
        self._fill(samples)
        columns = zip(COLUMNS, np.array(self._rows).T, strict=True)
        return {
            **{name: self.last[name] for name in ("id", "kind", "length_m")},
            "limits_N": self._limits_N and list(self._limits_N),
            "leader": self._leader,
            **{name: column(values) for name, values in columns if not np.isnan(values).all()},
            "states": self._states.list,
            "held": self._held.list,
            "texts": self._texts.list,
            "severities": self._severities.list,
            "plans": [[t_s, draw(plan)] for t_s, plan in self.plans.list],
            "items": self.items.list,
        }

    def _fill(self, samples: int) -> None:
        """Fill a gap: not heard before its first sample, later dropped for its silence."""
        is_heard = bool(self._rows) and self._rows[-1] is not _NOTHING
        self._rows += [_FORGOTTEN if is_heard else _NOTHING] * (samples - len(self._rows))


def _number(vessel: Told, column_name: str) -> float:
    if column_name in _ESCS:
        side, name = _ESCS[column_name]
        value = vessel["escs"][side][name] if vessel["escs"] else None
    else:
        name, place = _PLACES.get(column_name, (column_name, None))
        value = vessel[name]
        if value is not None and place is not None:
            value = value[place]
    return nan if value is None else float(value)


def messages_of(packets: Iterable[Packet]) -> Iterator[tuple[float, Message]]:
    """Seconds since the first message, and each message; skips damaged ones.

    Skips unknown messages too: their checksum cannot be verified, and any file may contain bytes
    that look like one.
    """
    ear, t_s, before_us = Ear(stream=False), 0.0, -1
    for packet in packets:
        for message in ear.hear(packet.frame):
            if message.fields is None:
                continue
            step_s = 1e-6 * (packet.t_us - before_us) if before_us >= 0 else 0.0
            t_s += step_s if 0.0 < step_s < _LONGEST_GAP_S else 0.0
            before_us = packet.t_us
            yield t_s, message
