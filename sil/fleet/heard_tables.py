# SPDX-License-Identifier: MIT
"""The tables that boats pass on, as a station overhears them: the members and their places."""

from collections.abc import Collection

from sil.wire.fleet_table import HeardTable, heard_table
from sil.wire.mavlink_ear import Ear
from sil.wire.mavlink_frames import frames
from sil.wire.mavlink_messages import FLEET_TABLE

_MOST_SENDERS = 255


class HeardTables:
    """The tables of each sender, merged: a member has its place in the last one that lists it."""

    def __init__(self) -> None:
        self._of: dict[tuple[int, int], HeardTable] = {}
        self._last: dict[tuple[int, int], HeardTable] = {}

    def hear(self, data: bytes) -> None:
        """Process whole frames."""
        if FLEET_TABLE.to_bytes(3, "little") not in data:
            return
        for number, system, component, frame in frames(data):
            sound = number == FLEET_TABLE and any(Ear(stream=False).hear(frame))
            sender = system, component
            if not sound or (len(self._of) >= _MOST_SENDERS and sender not in self._of):
                continue
            told = self._last[sender] = heard_table(frame)
            known = self._of[sender].places if sender in self._of else {}
            self._of[sender] = told._replace(places=known | told.places)

    def whole(self, epoch: int, digest: int) -> HeardTable | None:
        """The table with this epoch and digest, if it is the last one of any sender."""
        last = self._last.values()
        return next((it for it in last if (it.epoch, it.digest) == (epoch, digest)), None)

    def of(self, senders: Collection[tuple[int, int]]) -> HeardTable:
        """The tables of these senders (system, component), merged: a newer one overrides."""
        told = [table for sender, table in self._of.items() if sender in senders]
        whole = HeardTable(0, False, {})
        for table in sorted(told, key=lambda one: one.epoch):
            whole = table._replace(places=whole.places | table.places)
        return whole
