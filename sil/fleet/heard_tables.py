# SPDX-License-Identifier: MIT
"""The tables that boats pass on, as a station overhears them: the members and their places."""

import struct
from collections.abc import Collection
from typing import NamedTuple

from sil.scenario.formation import Place
from sil.wire.mavlink_ear import Ear
from sil.wire.mavlink_frames import HEADER, MAGIC_2, frames
from sil.wire.mavlink_messages import FLEET_TABLE

_HEAD, _MEMBER = struct.Struct("<HHHB"), struct.Struct("<BBBBhh")
_TURNS = 1
_MOST_SENDERS = 255


class HeardTable(NamedTuple):
    """`turns`: the places are ahead and to starboard, m; else north and east."""

    epoch: int
    turns: bool
    places: dict[int, Place]


class HeardTables:
    """The tables of each sender, merged: a member has its place in the last one that lists it."""

    def __init__(self) -> None:
        self._of: dict[tuple[int, int], HeardTable] = {}

    def hear(self, data: bytes) -> None:
        """Process whole frames."""
        if FLEET_TABLE.to_bytes(3, "little") not in data:
            return
        for number, system, component, frame in frames(data):
            sound = number == FLEET_TABLE and any(Ear(stream=False).hear(frame))
            sender = system, component
            if not sound or (len(self._of) >= _MOST_SENDERS and sender not in self._of):
                continue
            told = _table_of(frame)
            known = self._of[sender].places if sender in self._of else {}
            self._of[sender] = told._replace(places=known | told.places)

    def of(self, senders: Collection[tuple[int, int]]) -> HeardTable:
        """The tables of these senders (system, component), merged: a newer one overrides."""
        told = [table for sender, table in self._of.items() if sender in senders]
        whole = HeardTable(0, False, {})
        for table in sorted(told, key=lambda one: one.epoch):
            whole = table._replace(places=whole.places | table.places)
        return whole


def _table_of(frame: bytes) -> HeardTable:
    payload = frame[HEADER[MAGIC_2] : HEADER[MAGIC_2] + frame[1]]
    payload += bytes(_HEAD.size + -(len(payload) - _HEAD.size) % _MEMBER.size)
    _, epoch, _, flags = _HEAD.unpack_from(payload)
    places: dict[int, Place] = {}
    at = _HEAD.size
    while at + _MEMBER.size <= len(payload) and payload[at] != 0:
        system, _, _, _, x_cm, y_cm = _MEMBER.unpack_from(payload, at)
        places[system] = 0.01 * x_cm, 0.01 * y_cm
        at += _MEMBER.size
    return HeardTable(epoch, bool(flags & _TURNS), places)
