# SPDX-License-Identifier: MIT
"""Tables that a station sends: a shape's places for the boats, or a table that stops all boats."""

import difflib
import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, get_args

from sil.fleet.lead import root
from sil.fleet.station import STALE_S, Station
from sil.scenario.formation import Formation, Place, Shape, slots
from sil.wire.fleet_table import MOST_MEMBERS, Member, table_message

LAST_EPOCH = 65535
_FAR_ABOVE = 1000  # epochs; each table takes one
_EPOCH_S = 600.0  # of the time of day; they begin again after 455 days
_FARTHEST_M = 327.0  # on the wire, places are in cm, in 16 bits
_APART_M = 10.0  # spacing in a table that stops boats whose places are unknown
_GATHER_S = 1.5  # until all boats have sent a beacon
_BURST = 3
_PAUSE_S = 2.4  # boats pass no table on that they have heard in the last half second


def shape_places(shape: str, boats: int, spacing_m: float | None) -> list[Place]:
    """Places of a shape by name, or of a TOML file, m, relative to the first; ValueError."""
    names: tuple[Shape, ...] = get_args(Shape)
    if shape in names:
        if spacing_m is None:
            raise ValueError(f"{shape}: --spacing M is missing")
        if not 0.0 < spacing_m < math.inf:
            raise ValueError(f"--spacing {spacing_m:g}: must be greater than 0")
        places = slots(Formation(shape=shape, boats=boats, spacing_m=spacing_m))
    elif shape.endswith(".toml"):
        places = _read(Path(shape))
        if len(places) != boats:
            raise ValueError(f"{shape}: {len(places)} places for {boats} boats")
    else:
        near = difflib.get_close_matches(shape, names, 1)
        hint = f'; did you mean "{near[0]}"?' if near else ""
        raise ValueError(f'unknown shape "{shape}"{hint} (or a file of places: NAME.toml)')
    x, y = places[0]
    return [(place[0] - x, place[1] - y) for place in places]


def check_shape(shape: str, spacing_m: float | None) -> None:
    """ValueError if no number of boats can take the shape."""
    if shape.endswith(".toml"):
        if spacing_m is not None:
            raise ValueError(f"--spacing: {shape} has the places")
        _read(Path(shape))
    else:
        shape_places(shape, 1, spacing_m)


def _read(path: Path) -> list[Place]:
    """Read `places_m = [[ahead, starboard], …]`; the first place is the leader's."""
    try:
        document: dict[str, Any] = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    rows = document.get("places_m")
    if not isinstance(rows, list) or document.keys() != {"places_m"}:
        raise ValueError(f"{path}: must contain only places_m = [[ahead, starboard], …]")
    if not rows:
        raise ValueError(f"{path}: places_m is empty")
    for row in rows:
        pair = isinstance(row, list) and len(row) == 2
        if not pair or not all(type(x) in (int, float) and math.isfinite(x) for x in row):
            raise ValueError(f"{path}: {row} is not [ahead, starboard] in m")
    return [(float(x), float(y)) for x, y in rows]


def check(places: Sequence[Place], boats: Sequence[int], least_m: float, why: str) -> None:
    """ValueError if a table cannot carry the places, or if two are nearer than `least_m`."""
    if len(boats) > MOST_MEMBERS:
        raise ValueError(f"{len(boats)} boats: a table has at most {MOST_MEMBERS}")
    for boat, place in zip(boats, places, strict=True):
        if max(map(abs, place)) > _FARTHEST_M:
            raise ValueError(f"the place of boat {boat} is over {_FARTHEST_M:g} m from boat 1's")
    pairs = combinations(range(len(boats)), 2)
    apart = [(math.dist(places[i], places[j]), i, j) for i, j in pairs]
    nearest_m, i, j = min(apart, default=(math.inf, 0, 0))
    if nearest_m < least_m:
        pair = f"places {i + 1} and {j + 1}"
        raise ValueError(f"{pair} are {nearest_m:.2f} m apart, the least is {least_m:.2f} m: {why}")


def assigned(places: Sequence[Place], present: Sequence[Place]) -> list[Place]:
    """The places in the order of the boats: the first keeps its own, the others move least.

    The assignment minimizes the sum of squared distances, so the ways have no reason to cross.
    `present`: the boats' positions relative to the first, in the axes of the places.
    """
    import numpy as np  # noqa: PLC0415 – needed only here
    from scipy.optimize import linear_sum_assignment  # noqa: PLC0415

    if len(places) < 2:
        return list(places)
    way = np.asarray(present)[1:, None, :] - np.asarray(places)[None, 1:, :]
    _, chosen = linear_sum_assignment((way**2).sum(axis=2))
    return [places[0], *(places[1 + int(i)] for i in chosen)]


def present_places(station: Station, boats: Sequence[int], *, turning: bool) -> list[Place] | None:
    """Positions of the boats, m from the first; None if a place or heading is unknown.

    North and east, or ahead and to starboard of the first boat.
    """
    told = {vessel["id"]: vessel for vessel in station.fleet.vessels(station.now_s())}
    known = [told[boat] for boat in boats if boat in told and _is_placed(told[boat])]
    if len(known) < len(boats):
        return None
    first = known[0]
    if turning and first["psi_rad"] is None:
        return None
    psi = first["psi_rad"] if turning else 0.0
    cos, sin = math.cos(psi), math.sin(psi)
    ways = [(each["x_m"] - first["x_m"], each["y_m"] - first["y_m"]) for each in known]
    return [(cos * north + sin * east, cos * east - sin * north) for north, east in ways]


def _is_placed(vessel: dict[str, Any]) -> bool:
    return vessel["x_m"] is not None and vessel["place_age_s"] < STALE_S


def told_epochs(station: Station, boats: Iterable[int]) -> dict[int, int]:
    """The epoch of the newest table of each of these boats; boats without a table are left out."""
    told = {boat: station.last_beacon(boat) for boat in boats}
    return {boat: beacon.epoch for boat, beacon in told.items() if beacon and beacon.epoch}


def epoch_at(unix_s: float) -> int:
    """The least epoch of a table made at this time, s since 1970.

    So a boat that was away with an older session's table does not bring that table back.
    """
    return 1 + int(unix_s / _EPOCH_S) % LAST_EPOCH


def doubtful_epochs(told: Mapping[int, int], least: int = 0) -> dict[int, int]:
    """The epochs that one boat alone reports, far above those of all others and above `least`."""
    doubtful: dict[int, int] = {}
    by_epoch = sorted(told, key=lambda boat: told[boat])
    while len(by_epoch) > 1:
        if told[by_epoch[-1]] - max(told[by_epoch[-2]], least) <= _FAR_ABOVE:
            break
        boat = by_epoch.pop()
        doubtful[boat] = told[boat]
    return doubtful


def newest_epoch(told: Mapping[int, int], least: int = 0) -> int:
    """The greatest epoch that is not doubtful; 0: no boat has a table."""
    doubtful = doubtful_epochs(told, least)
    return max((epoch for boat, epoch in told.items() if boat not in doubtful), default=0)


def warnings_of(told: Mapping[int, int], least: int = 0) -> list[str]:
    """A sentence for each boat whose epoch is doubtful."""
    most = newest_epoch(told, least)
    return [
        f"boat {boat} alone reports table {epoch}, the others at most {most}: ignored; "
        f"restart boat {boat} if this persists"
        for boat, epoch in sorted(doubtful_epochs(told, least).items())
    ]


def star(boats: Sequence[int], places: Sequence[Place], lengths_m: Sequence[float]) -> list[Member]:
    """Members of a table by rank; all follow the first one."""
    return [
        Member(boat, 0 if boat == boats[0] else boats[0], place, length_m)
        for boat, place, length_m in zip(boats, places, lengths_m, strict=True)
    ]


class StopTable:
    """Stops the fleet's members, even those that no order reaches, because boats pass a table on.

    Nothing is sent while no boat reports a table. The table's places are the boats' positions, so
    that boats that follow again after a stop keep about that shape. If a boat's position is
    unknown, the places are those of the tables that boats have passed on.
    """

    def __init__(self, station: Station) -> None:
        self._station = station
        self._epoch = 0
        self._boats: list[int] = []
        self._members: list[Member] = []
        self._turns = False
        self._count = 0
        self._sent_s = 0.0

    def send(self, boats: Sequence[int], trusted: Sequence[int]) -> None:
        """Send the table, with a greater epoch if further boats or another table have appeared.

        After three times, pauses so that the boats can pass it on. `trusted`: boats whose epochs
        count even if they are doubtful.
        """
        told = told_epochs(self._station, boats)
        least = epoch_at(self._station.unix_s())
        newest = max(newest_epoch(told, least), *(told.get(boat, 0) for boat in trusted), 0)
        now_s = self._station.now_s()
        if newest == 0 or not boats or now_s < _GATHER_S:
            return
        top, heard = root(self._station), self._station.boats()
        ranked = sorted(boats, key=lambda boat: (boat != top, boat not in heard, boat))
        listed = ranked[:MOST_MEMBERS]
        if newest > self._epoch or set(listed) - set(self._boats):
            self._boats = listed
            self._epoch = min(max(newest, self._epoch) + 1, LAST_EPOCH)
            places, self._turns = self._places(self._boats)
            self._members = star(self._boats, places, [0.0] * len(self._boats))
            self._count = 0
        if self._count < _BURST or now_s - self._sent_s >= _PAUSE_S:
            self._count += 1
            self._sent_s = now_s
            self._station.send(self._frame())

    def _frame(self) -> bytes:
        return table_message(self._epoch, self._members, turns=self._turns, stop=True)

    def _places(self, boats: Sequence[int]) -> tuple[list[Place], bool]:
        """The boats' places, and whether these turn with the leader."""
        places = present_places(self._station, boats, turning=False)
        if places is not None and _can_be_told(places):
            return places, False
        table = self._station.table()
        places = []
        astern_m = min((table.places[boat][0] for boat in boats if boat in table.places), default=0)
        for boat in boats:
            places.append(table.places.get(boat, (astern_m - _APART_M, 0.0)))
            astern_m -= 0.0 if boat in table.places else _APART_M
        places = [(x - places[0][0], y - places[0][1]) for x, y in places]
        if _can_be_told(places):
            return places, table.turns
        return [(-_APART_M * i, 0.0) for i in range(len(boats))], False


def _can_be_told(places: Sequence[Place]) -> bool:
    apart = all(math.dist(*pair) > 0.02 for pair in combinations(places, 2))
    return apart and max(max(map(abs, place)) for place in places) < _FARTHEST_M
