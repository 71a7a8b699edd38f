# SPDX-License-Identifier: MIT
"""A change of shape: asks the boats for their lengths, makes a table, checks that all have it.

Source: firmware/docs/FLEET.md.
"""

from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.fleet.station import Station, Text
from sil.fleet.tables import (
    LAST_EPOCH,
    assigned,
    check,
    doubtful_epochs,
    epoch_at,
    newest_epoch,
    present_places,
    shape_places,
    star,
    told_epochs,
    warnings_of,
)
from sil.scenario.formation import Place
from sil.wire.fleet_table import (
    Beacon,
    HeardTable,
    Member,
    beacon_message,
    heard_table,
    table_message,
)

#: Least distance of slots, ratio to FS_SEP_M; see FLEET.md, "form".
SLOTS_GUARDS = 2.9
IN_S = 3.0
_PATIENCE_S, _RETRY_S = 8.0, 0.6
_BEACONS_S = 2.5  # two beacons of each boat; a boat without a table sends none
_TOLD_S = 6.0  # until all beacons report the new leaders: five of each boat
_STOPS_S = 1.0  # until a boat that refuses its new slot has stopped
_GUARD_LENGTHS = 1.2  # boat lengths that make up FS_SEP_M if it is negative
_ASKED = ("BOAT_LEN", "FS_SEP_M")


class Change(NamedTuple):
    """The result: a text; each boat's place; each refusing boat's reason, by system id; warnings.

    There are no places if the boats choose them among themselves.
    """

    words: str
    places: list[Place]
    missing: dict[int, str]
    warnings: list[str]


def change(
    station: Station,
    boats: Sequence[int],
    shape: str,
    spacing_m: float | None,
    *,
    turning: bool,
) -> Change:
    """Bring boats, by rank, into a shape. ValueError, with nothing sent, if it is impossible."""
    places = shape_places(shape, len(boats), spacing_m)
    if unheard := [boat for boat in boats if not station.is_heard(boat)]:
        raise ValueError(f"boat {unheard[0]} is not heard: name the others with --boats")
    lengths_m, guard_m = _sizes(station, boats)
    longest_m = max(lengths_m)
    least_m, why = SLOTS_GUARDS * guard_m, f"{SLOTS_GUARDS:g} times FS_SEP_M"
    if guard_m == 0.0:
        least_m, why = _GUARD_LENGTHS * longest_m, f"{_GUARD_LENGTHS:g} hull lengths"
    check(places, boats, least_m, why)
    station.run(_BEACONS_S, lambda: all(station.beacon(boat) for boat in boats))
    told = told_epochs(station, boats)
    before = [beacon for boat in boats if (beacon := station.beacon(boat)) and beacon.epoch]
    least = epoch_at(station.unix_s())
    newest = newest_epoch(told, least)
    epoch = max(newest + 1, least)
    if epoch > LAST_EPOCH:
        raise ValueError(f"epoch {LAST_EPOCH} is the last one: restart all boats at once")
    # A boat with a table knows the others' places in it. Then the boats assign the new places
    # themselves, and move there together.
    under_way = newest > 0
    present = None if under_way else present_places(station, boats, turning=turning)
    if present is not None:
        places = assigned(places, present)
    members = star(boats, places, lengths_m)
    table = _Table(station, epoch, members, least=least, turns=turning, assign=under_way)
    since_s = table.since_s
    table.spread(before)

    def astray() -> list[int]:
        late = table.missing()
        now = {boat: station.beacon(boat) for boat in boats[1:] if boat not in late}
        return [boat for boat, told in now.items() if told is None or told.follows != boats[0]]

    station.run(IN_S - (station.now_s() - since_s))
    station.run(_TOLD_S, lambda: not astray())
    station.run(_STOPS_S)
    late = table.missing()
    strays = dict.fromkeys(astray(), f"does not report that it follows boat {boats[0]}")
    how = ""
    if under_way:
        how = "; the boats assign the places and move there together"
    elif present is None:
        how = "; some boats report no position: places by rank"
    there = len(boats) - len(late) - len(strays)
    words = f"table {epoch} is in force with {there} of {len(boats)} boats{how}"
    if (other := table.newest()) and table.is_ours(other) is False:
        words = f"table {other.epoch} of another station is in force, not this {shape}"
    missing_ones = {boat: _why(table, boat) for boat in late}
    stops = {each.system: each.text for each in station.texts if _stops(each, boats, since_s)}
    stopped = {
        boat: f"{text}; flotilla fleet follow --boats {boat}" for boat, text in stops.items()
    }
    return Change(
        words,
        [] if under_way else places,
        {**strays, **stopped, **missing_ones},
        warnings_of(told, least),
    )


class _Table:
    """A table of this station, from the first message on; `assign`: the boats assign the places."""

    def __init__(
        self,
        station: Station,
        epoch: int,
        members: Sequence[Member],
        *,
        least: int,
        turns: bool,
        assign: bool,
    ) -> None:
        self.station, self.epoch = station, epoch
        self.boats = [member.system for member in members]
        self.since_s = station.now_s()
        self._members, self._turns, self._assign = members, turns, assign
        self._least = least
        self._sent = heard_table(self._frame())

    def spread(self, before: Sequence[Beacon]) -> None:
        """Send it until all boats report it. `before`: their last beacons with a table."""
        station = self.station
        while self.missing() and station.now_s() - self.since_s < _PATIENCE_S:
            station.send(self._frame())
            newest = self.newest()
            if before and newest and self.is_ours(newest) is None:
                epoch, digest = Counter((it.epoch, it.digest) for it in before).most_common(1)[0][0]
                sequence = int(station.now_s() / _RETRY_S) & 0xFF
                station.send(beacon_message(epoch, digest, sequence, self._sender()))
            station.run(_RETRY_S, lambda: not self.missing())

    def newest(self) -> Beacon | None:
        """A beacon with the newest table that a boat reports, if it is as new as this one."""
        epochs = told_epochs(self.station, self.boats)
        believed = epochs.keys() - doubtful_epochs(epochs, self._least).keys()
        told = filter(None, map(self.station.last_beacon, believed))
        newest = max(told, key=lambda it: (it.epoch, it.digest), default=None)
        return newest if newest and newest.epoch >= self.epoch else None

    def is_ours(self, told: Beacon) -> bool | None:
        """Whether a boat reports this table; None: no boat has passed it on yet.

        Boats that assign the places make a table of their own, with the same places.
        """
        if told.epoch != self.epoch or not self._assign:
            return (told.epoch, told.digest) == (self.epoch, self._sent.digest)
        given = self.station.whole_table(told.epoch, told.digest)
        return None if given is None else _shape(given) == _shape(self._sent)

    def missing(self) -> list[int]:
        """The boats that do not report this table, or all if another one replaces it."""
        newest = self.newest()
        if newest is None or not self.is_ours(newest):
            return self.boats
        told = {boat: self.station.last_beacon(boat) for boat in self.boats}
        return [boat for boat, it in told.items() if it is None or it.digest != newest.digest]

    def _frame(self) -> bytes:
        left_s = max(0.0, IN_S - (self.station.now_s() - self.since_s))
        return table_message(
            self.epoch,
            self._members,
            turns=self._turns,
            assign=self._assign,
            in_s=left_s,
            sender=self._sender(),
        )

    def _sender(self) -> tuple[int, int]:
        return self.station.system, mavlink.MAV_COMP_ID_USER1


def _shape(table: HeardTable) -> tuple[bool, list[int], list[Place]]:
    """All that the assignment of places leaves as it is."""
    return table.turns, list(table.places), sorted(table.places.values())


def _stops(text: Text, boats: Sequence[int], since_s: float) -> bool:
    return text.system in boats and text.at_s >= since_s and text.text.startswith("HOLD: ")


def _sizes(station: Station, boats: Sequence[int]) -> tuple[list[float], float]:
    """The boats' lengths and the greatest FS_SEP_M, m. ValueError if a boat sends none."""
    since_s = station.now_s()

    def missing() -> list[tuple[int, str]]:
        wanted = ((boat, name) for boat in boats for name in _ASKED)
        return [one for one in wanted if one not in station.parameters]

    while missing() and station.now_s() - since_s < _PATIENCE_S:
        for boat, name in missing():
            ask = mavlink.MAVLink_param_request_read_message(
                boat, station.component(boat), name.encode(), -1
            )
            station.say(ask, boat)
        station.run(_RETRY_S, lambda: not missing())
    for boat, name in missing():
        raise ValueError(f"boat {boat} does not report its {name}, which a shape needs")
    lengths_m = [station.parameters[boat, "BOAT_LEN"] for boat in boats]
    guards_m = [station.parameters[boat, "FS_SEP_M"] for boat in boats]
    return lengths_m, max(
        guard_m if guard_m >= 0.0 else _GUARD_LENGTHS * length_m
        for guard_m, length_m in zip(guards_m, lengths_m, strict=True)
    )


def _why(table: _Table, boat: int) -> str:
    refusals = [
        each.text
        for each in table.station.texts
        if each.system == boat
        and each.at_s >= table.since_s
        and each.text.startswith("Fleet table")
    ]
    beacon = table.station.last_beacon(boat)
    if refusals:
        return refusals[-1]
    if beacon is not None and beacon.epoch >= table.epoch:
        if table.is_ours(beacon) is None:
            return f"has a table {beacon.epoch}, but no boat passes it on: it may be another one"
        return f"has table {beacon.epoch} instead, which another station sent meanwhile"
    return f"does not confirm table {table.epoch}: check that it obeys this station (MAV_GCS_SYSID)"
