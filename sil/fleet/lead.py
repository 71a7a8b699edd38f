# SPDX-License-Identifier: MIT
"""Finds the leader of a fleet from the boats' messages."""

from collections import Counter
from collections.abc import Mapping

from sil.fleet.station import Station
from sil.view.seen_table import listed


def leaders(station: Station) -> list[int]:
    """The boats whose last beacons claim the lead: several if the radio network was split."""
    beacons = ((system, station.beacon(system)) for system in station.boats())
    return [system for system, beacon in beacons if beacon is not None and beacon.leads]


def followed_by(station: Station, system: int) -> int | None:
    """The leader of a boat, from its beacon or telemetry; None if unknown, or if the boat leads."""
    beacon = station.beacon(system)
    if beacon is not None and beacon.epoch:
        return beacon.follows or None
    vessel = station.fleet.systems.get(system)
    leader = None if vessel is None else vessel.value("LEADER")
    return int(leader) if leader and leader != system else None


def root(station: Station) -> int | None:
    """The vessel at the top: the boat that leads, or the vessel that most chains of leaders end at.

    None if it is unknown, or if two boats lead. A boat that no longer leads may still follow
    another, which follows it; therefore the majority decides.
    """
    told = leaders(station)
    if told:
        return told[0] if len(told) == 1 else None
    above = {system: followed_by(station, system) for system in station.boats()}
    votes = Counter(top for top in (_top(above, system) for system in above) if top is not None)
    first, second = [*votes.most_common(2), (None, 0), (None, 0)][:2]
    return None if second[1] == first[1] else first[0]


def leading_boat(station: Station) -> int:
    """The boat that receives commands for the whole fleet; ValueError if there is none."""
    told = leaders(station)
    if len(told) > 1:
        raise ValueError(f"{listed(told)} lead: choose one with --boats {told[0]}")
    top = root(station)
    if top is None or top not in station.boats():
        whom = (
            "the leader is unknown" if top is None else f"vessel {top} leads, which is not a boat"
        )
        raise ValueError(f"{whom}: choose the boat that is to lead with --boats N")
    return top


def _top(above: Mapping[int, int | None], system: int) -> int | None:
    """The end of the chain of leaders, or where it closes to a cycle; None: it follows nobody."""
    seen = {system}
    top = above[system]
    while top is not None and top not in seen and above.get(top) is not None:
        seen.add(top)
        top = above[top]
    return top
