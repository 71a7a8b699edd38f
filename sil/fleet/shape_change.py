# SPDX-License-Identifier: MIT
"""A change of shape: asks the boats for their lengths, makes a table, checks that all have it.

Source: firmware/docs/FLEET.md.
"""

from collections.abc import Sequence
from typing import NamedTuple

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.fleet.station import Station, Text
from sil.fleet.tables import (
    LAST_EPOCH,
    assigned,
    check,
    newest_epoch,
    present_places,
    shape_places,
    star,
    told_epochs,
    warnings_of,
)
from sil.scenario.formation import Place
from sil.wire.fleet_table import digest_of, table_message

IN_S = 3.0
_PATIENCE_S, _RETRY_S = 8.0, 0.6
_BEACONS_S = 2.5  # two beacons of each boat; a boat without a table sends none
_TOLD_S = 6.0  # until all beacons report the new leaders: five of each boat
_STOPS_S = 1.0  # until a boat that refuses its new slot has stopped
_GUARD_LENGTHS = 1.2  # boat lengths that make up FS_SEP_M if it is negative
_SLOTS_GUARDS = 1.5  # least distance of slots, as a multiple of FS_SEP_M
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
    least_m, why = _SLOTS_GUARDS * guard_m, f"{_SLOTS_GUARDS:g} times FS_SEP_M"
    if guard_m == 0.0:
        least_m, why = _GUARD_LENGTHS * longest_m, f"{_GUARD_LENGTHS:g} hull lengths"
    check(places, boats, least_m, why)
    station.run(_BEACONS_S, lambda: all(station.beacon(boat) for boat in boats))
    told = told_epochs(station, boats)
    epoch = newest_epoch(told) + 1
    if epoch > LAST_EPOCH:
        raise ValueError(f"epoch {LAST_EPOCH} is the last one: restart all boats at once")
    # A boat with a table knows the others' places in it. Then the boats assign the new places
    # themselves, and move there together.
    under_way = epoch > 1
    present = None if under_way else present_places(station, boats, turning=turning)
    if present is not None:
        places = assigned(places, present)
    members = star(boats, places, lengths_m)
    since_s = station.now_s()

    def frame() -> bytes:
        left_s = max(0.0, IN_S - (station.now_s() - since_s))
        ours = (station.system, mavlink.MAV_COMP_ID_USER1)
        return table_message(
            epoch, members, turns=turning, assign=under_way, in_s=left_s, sender=ours
        )

    sent = digest_of(frame())

    def missing() -> list[int]:
        now = {boat: station.beacon(boat) for boat in boats}
        ours = [beacon.digest for beacon in now.values() if beacon and beacon.epoch == epoch]
        # boats that assigned the places differently agree on the greater digest
        digest = max(ours, default=0) if under_way else sent
        return [
            boat
            for boat, beacon in now.items()
            if beacon is None or (beacon.epoch, beacon.digest) != (epoch, digest)
        ]

    while missing() and station.now_s() - since_s < _PATIENCE_S:
        station.send(frame())
        station.run(_RETRY_S, lambda: not missing())
    late = missing()

    def astray() -> list[int]:
        now = {boat: station.beacon(boat) for boat in boats[1:] if boat not in late}
        return [boat for boat, told in now.items() if told is None or told.follows != boats[0]]

    station.run(IN_S - (station.now_s() - since_s))
    station.run(_TOLD_S, lambda: not astray())
    station.run(_STOPS_S)
    strays = dict.fromkeys(astray(), f"does not report that it follows boat {boats[0]}")
    how = ""
    if under_way:
        how = "; the boats assign the places and move there together"
    elif present is None:
        how = "; some boats report no position: places by rank"
    there = len(boats) - len(late) - len(strays)
    words = f"table {epoch} is in force with {there} of {len(boats)} boats{how}"
    missing_ones = {boat: _why(station, boat, epoch, since_s) for boat in late}
    stops = {each.system: each.text for each in station.texts if _stops(each, boats, since_s)}
    stopped = {
        boat: f"{text}; flotilla fleet follow --boats {boat}" for boat, text in stops.items()
    }
    return Change(
        words, [] if under_way else places, {**strays, **stopped, **missing_ones}, warnings_of(told)
    )


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
            component = mavlink.MAV_COMP_ID_AUTOPILOT1
            ask = mavlink.MAVLink_param_request_read_message(boat, component, name.encode(), -1)
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


def _why(station: Station, boat: int, epoch: int, since_s: float) -> str:
    refusals = [
        each.text
        for each in station.texts
        if each.system == boat and each.at_s >= since_s and each.text.startswith("Fleet table")
    ]
    beacon = station.beacon(boat)
    if refusals:
        return refusals[-1]
    if beacon is not None and beacon.epoch >= epoch:
        return f"has table {beacon.epoch} instead, which another station sent meanwhile"
    return f"does not confirm table {epoch}: check that it obeys this station (MAV_GCS_SYSID)"
