# SPDX-License-Identifier: MIT
"""A sentence on the fleet's table, from its members' beacons and the table's own messages."""

from collections.abc import Sequence

from sil.wire import mavlink_messages as messages
from sil.wire.fleet_table import Beacon, beacon_of
from sil.wire.mavlink_ear import Message

_FRESH_S = 3.0  # each member sends a beacon every 1.2 s
# Flags of a FLEET_TABLE: places are still to be assigned; its time has come.
_REQUEST, _IN_FORCE = 4, 8


class SeenTable:
    """The last beacon of each system, and when the last table that was heard comes into force."""

    def __init__(self) -> None:
        self._beacons: dict[int, tuple[float, Beacon]] = {}
        self._next = 0, 0.0  # epoch, listener's time (s)

    def hear(self, message: Message, now_s: float) -> None:
        """Process a message; only those with a beacon or a table matter."""
        if not message.fields:
            return
        if message.number == messages.FLEET_BEACON:
            self._beacons[message.system] = now_s, beacon_of(message.fields)
        elif message.number == messages.FLEET_TABLE and not message.fields[4] & _REQUEST:
            in_ms, epoch, _, _, flags = message.fields[:5]
            self._next = epoch, now_s + (0.0 if flags & _IN_FORCE else 0.001 * in_ms)

    def line(self, now_s: float) -> str:
        """The newest table, who leads, and who has an older table; empty if there is none."""
        fresh = {k: b for k, (at_s, b) in self._beacons.items() if now_s - at_s < _FRESH_S}
        newest = max((beacon.epoch for beacon in fresh.values()), default=0)
        if newest == 0:
            return ""
        epoch, at_s = self._next
        leads = [system for system, beacon in sorted(fresh.items()) if beacon.leads]
        late = [system for system, beacon in sorted(fresh.items()) if 0 < beacon.epoch < newest]
        parts = [f"table {newest}"]
        if epoch == newest and at_s > now_s:
            parts[0] += f" comes into force in {at_s - now_s:.0f} s"
        verb = "leads" if len(leads) == 1 else "lead"
        parts.append(f"{listed(leads)} {verb}" if leads else "no boat leads")
        if late:
            parts.append(f"{listed(late)} {'has' if len(late) == 1 else 'have'} an older one")
        return ", ".join(parts)


def listed(boats: Sequence[int]) -> str:
    """The boats' names: boat 1; boats 1, 2 and 3."""
    *most, last = map(str, boats)
    return f"boats {', '.join(most)} and {last}" if most else f"boat {last}"
