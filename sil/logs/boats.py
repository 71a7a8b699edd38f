# SPDX-License-Identifier: MIT
"""Merges the telemetry and CAN logs of one or several boats into one MCAP file.

A vessel's messages come from its own tlog if that is given, otherwise from the first tlogs that
contain any. A boat has a tlog for each of its links, and a message is in the tlog of every link
that carried it; equal payloads within 0.2 s count once.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import partial
from heapq import merge
from operator import itemgetter
from pathlib import Path
from typing import NamedTuple

from sil.logs import candump, telemetry, tlog_reader, track
from sil.logs.escs import EscBus, EscReport
from sil.logs.output import Output
from sil.logs.telemetry import Telemetry
from sil.logs.tlog_reader import Facts
from sil.logs.track import Track
from sil.wire.mavlink_messages import ESC_INFO, ESC_STATUS
from sil.wire.tlog import Packet, packets

_TWICE_US = 200_000
_MANY = 10_000

Progress = Callable[[float], None]
Teller = int | Path


class Done(NamedTuple):
    """Result of a conversion: names of vessels, messages written, damaged bytes."""

    vessels: list[str]
    messages: int
    damaged: int


class _Vessel:
    """The messages of one MAVLink system."""

    def __init__(self, output: Output, name: str, facts: Iterable[Facts], system: int) -> None:
        components = [c for one in facts for c in one.components.get(system, ())]
        origins = [one.origins[system] for one in facts if system in one.origins]
        self._component = min(components, default=None)
        self._track = Track(output, name, origins[0] if origins else None)
        self._escs = EscReport(output, name)
        self.telemetry = Telemetry(output, name, tells_law=True)
        self.has_bus = False

    def take(self, packet: Packet) -> bool:
        """Process a packet of `tlog_reader.NEEDED`; False if it is damaged."""
        message, t_ns, kind = tlog_reader.decoded(packet), 1000 * packet.t_us, packet.message_id
        if message is None:
            return False
        if kind in telemetry.MESSAGES:
            self.telemetry.take(t_ns, message)
        elif kind in track.MESSAGES:
            if packet.component == self._component:
                self._track.take(t_ns, message)
        elif kind == ESC_INFO:
            self._escs.on_info(message)
        elif kind == ESC_STATUS and not self.has_bus:
            self._escs.on_status(t_ns, message)
        return True


def convert(tlogs: Sequence[Path], candumps: Sequence[Path], out: Path, progress: Progress) -> Done:
    """Write the logs' contents to `out`, with the logs' own UNIX times.

    A candump log belongs to the boat whose tlog is in the same folder, else it is named after its
    bus. Raises ValueError for a file that is not a log, OSError for one that cannot be read.
    """
    size = sum(path.stat().st_size for path in (*tlogs, *tlogs, *candumps))
    facts: dict[Path, Facts] = {}
    done = 0
    for path in tlogs:
        facts[path] = tlog_reader.facts(path)
        done += path.stat().st_size
        progress(done / size)
    origins = [origin for one in facts.values() for origin in one.origins.values()]
    with Output(origins[0] if origins else None) as output:
        boats = _Boats(output, facts)
        sources = [boats.frames(path) for path in candumps]
        sources += [boats.packets(path) for path in tlogs]
        for count, (_, length, take) in enumerate(merge(*sources, key=itemgetter(0))):
            take()
            done += length
            if count % _MANY == 0:
                progress(min(1.0, done / size))
        boats.end()
        if not output.messages:
            raise ValueError("these logs contain no message of any boat")
        output.write(out)
        progress(1.0)
        return Done(sorted(output.vessels), output.messages, sum(boats.damaged))


# Time in us, bytes of the file since the previous record, action.
_Record = tuple[int, int, Callable[[], None]]


class _Boats:
    """The vessels of all logs; `damaged`: lengths of unreadable parts, bytes."""

    def __init__(self, output: Output, facts: dict[Path, Facts]) -> None:
        self.damaged: list[int] = []
        self._output = output
        self._facts = facts
        self._leaders = {system for one in facts.values() for system in one.leaders}
        # The source of each system's messages: its own logs, else the first that contain any.
        self._tellers: dict[int, Teller] = {
            one.owner: one.owner for one in facts.values() if one.owner is not None
        }
        self._once: dict[Teller, _Once] = {}
        self._vessels: dict[int, _Vessel] = {}

    def packets(self, path: Path) -> Iterator[_Record]:
        """The records of a tlog."""
        facts, length = self._facts[path], 0
        teller = path.parent if facts.owner is None else facts.owner
        once = self._once.setdefault(teller, _Once())
        for packet in packets(path.read_bytes(), self.damaged):
            length += packet.size
            if packet.message_id not in tlog_reader.NEEDED or not once.new(packet):
                continue
            if self._tellers.setdefault(packet.system, teller) == teller:
                yield packet.t_us, length, partial(self._take, packet)
                length = 0

    def frames(self, path: Path) -> Iterator[_Record]:
        """The records of a candump log; ValueError if it contains no frame."""
        name = candump.bus_of(path)
        beside = [one.owner for tlog, one in self._facts.items() if tlog.parent == path.parent]
        owners = {owner for owner in beside if owner is not None}
        if len(owners) == 1:
            owner = owners.pop()
            self._vessel(owner).has_bus = True
            name = self._name(owner)
        bus = EscBus(self._output, name)
        return (
            (frame.t_us, frame.size, partial(bus.on_frame, frame.t_us, frame.can_id, frame.data))
            for frame in candump.frames(path, self.damaged)
        )

    def end(self) -> None:
        """Finish after the last record."""
        for vessel in self._vessels.values():
            vessel.telemetry.end()

    def _take(self, packet: Packet) -> None:
        if not self._vessel(packet.system).take(packet):
            self.damaged.append(packet.size)

    def _vessel(self, system: int) -> _Vessel:
        if system not in self._vessels:
            # the boat's own log takes precedence
            facts = sorted(self._facts.values(), key=lambda one: one.owner != system)
            self._vessels[system] = _Vessel(self._output, self._name(system), facts, system)
        return self._vessels[system]

    def _name(self, system: int) -> str:
        return f"leader{system}" if system in self._leaders else f"boat{system}"


class _Once:
    """Recognises copies of a packet from other links."""

    def __init__(self) -> None:
        self._now: set[tuple[int, int, int, bytes]] = set()
        self._before = self._now
        self._since_us = 0

    def new(self, packet: Packet) -> bool:
        """Whether the packet is new: no equal one was seen in the last 0.2 s."""
        if not -_TWICE_US < packet.t_us - self._since_us < _TWICE_US:
            self._now, self._before, self._since_us = set(), self._now, packet.t_us
        key = (packet.system, packet.component, packet.message_id, packet.payload)
        if key in self._now or key in self._before:
            return False
        self._now.add(key)
        return True
