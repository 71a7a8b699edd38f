# SPDX-License-Identifier: MIT
"""A fleet's status as reported by its boats: a sentence, and a row for each boat."""

from collections.abc import Sequence
from typing import Any, NamedTuple

from rich.table import Table

from sil.fleet.lead import followed_by, leaders, root
from sil.fleet.station import STALE_S, Station
from sil.view.seen_table import listed

LEADING = ("AUTO", "GUIDED", "LOITER", "RTL")
_FOLLOWING = ("FORMATION", "COAST")


class Row(NamedTuple):
    """One boat; a value that is unknown, or older than 5 s, is None.

    `age_s`: time since its last message, None: never heard. `follows`: its leader. `off_m`:
    distance from its slot. `epoch`: that of its newest table. `why`: the reason why it does not
    sail.
    """

    system: int
    age_s: float | None = None
    state: str | None = None
    follows: int | None = None
    in_slot: bool | None = None
    off_m: float | None = None
    epoch: int | None = None
    fit: bool | None = None
    leads: bool | None = None
    battery_V: float | None = None
    why: tuple[str, ...] = ()

    @property
    def is_heard(self) -> bool:
        """Whether the boat is heard at present."""
        return self.age_s is not None and self.age_s < STALE_S


def rows_of(station: Station, boats: Sequence[int]) -> list[Row]:
    """A row for each boat."""
    told = {vessel["id"]: vessel for vessel in station.fleet.vessels(station.now_s())}
    return [_row(station, boat, told.get(boat)) for boat in boats]


def _row(station: Station, boat: int, vessel: dict[str, Any] | None) -> Row:
    if vessel is None:
        return Row(boat)
    if vessel["link_age_s"] >= STALE_S:
        return Row(boat, vessel["link_age_s"])
    beacon = station.beacon(boat)
    slot = vessel["in_slot"]
    return Row(
        system=boat,
        age_s=vessel["link_age_s"],
        state=vessel["state"],
        follows=followed_by(station, boat),
        in_slot=None if slot is None else bool(slot),
        off_m=vessel["error_m"],
        epoch=None if beacon is None else beacon.epoch,
        fit=None if beacon is None else beacon.fit,
        leads=None if beacon is None else beacon.leads,
        battery_V=vessel["battery_V"],
        why=tuple(vessel["held"]),
    )


def verdict(rows: Sequence[Row], top: int | None, two: Sequence[int] = ()) -> str:
    """The fleet's status in one sentence.

    `top`: the vessel that all follow, if known; `two`: boats that both lead.
    """
    silent = [row.system for row in rows if not row.is_heard]
    notes = [f"{listed(silent)} silent"] if silent else []
    if len(two) > 1:
        return "; ".join([f"{listed(two)} lead: the fleet is split", *notes])
    good = [row for row in rows if row.is_heard and _is_well(row, top)]
    if top is not None and any(row.state in _FOLLOWING for row in rows):
        whom = "boat" if any(row.system == top for row in rows) else "vessel"
        head = f"{len(good)} of {len(rows)} in formation behind {whom} {top}"
    else:
        states = [row.state or "unknown" for row in rows if row.is_heard]
        counts = [f"{states.count(state)} {state}" for state in dict.fromkeys(states)]
        head = f"nobody in formation: {', '.join(counts) or 'no boat is heard'}"
        return "; ".join([head, *notes])
    others = [row for row in rows if row.is_heard and row not in good]
    notes += [f"boat {row.system} {_trouble(row)}" for row in others]
    return "; ".join([head, *notes])


def table(rows: Sequence[Row]) -> Table:
    """The rows, for the terminal; a dash is unknown."""
    drawn = Table(box=None, pad_edge=False, header_style="bold")
    for name in ("boat", "state", "follows", "off slot", "table", "fit", "battery", "heard"):
        drawn.add_column(name, justify="right" if name in ("off slot", "battery") else "left")
    drawn.add_column("why", overflow="fold")
    for row in rows:
        whom = "leads" if row.leads else _dash(row.follows, "{}")
        drawn.add_row(
            str(row.system),
            row.state or "–",
            whom,
            _dash(row.off_m, "{:.2f} m"),
            _dash(row.epoch or None, "{}"),
            _dash(row.fit, {True: "yes", False: "no"}.get(bool(row.fit), "")),
            _dash(row.battery_V, "{:.1f} V"),
            "never" if row.age_s is None else f"{row.age_s:.1f} s ago",
            "; ".join(row.why),
        )
    return drawn


def of_station(station: Station, boats: Sequence[int]) -> tuple[str, Table, bool]:
    """The sentence, the table, and whether all boats are heard."""
    rows = rows_of(station, boats)
    return _words(station, rows), table(rows), all(row.is_heard for row in rows)


def verdict_of(station: Station, boats: Sequence[int]) -> str:
    """The sentence alone."""
    return _words(station, rows_of(station, boats))


def _words(station: Station, rows: Sequence[Row]) -> str:
    return verdict(rows, root(station), leaders(station))


def _is_well(row: Row, top: int | None) -> bool:
    if row.system == top:
        return row.state in LEADING or row.state in _FOLLOWING
    return row.state == "FORMATION" and row.in_slot is True


def _trouble(row: Row) -> str:
    if row.state == "FORMATION":
        if row.in_slot is None:
            return "does not report whether it is in its slot"
        return "closes up" + ("" if row.off_m is None else f", {row.off_m:.1f} m off")
    return f"is in {row.state}" if row.state else "does not report its state"


def _dash(value: object, form: str) -> str:
    return "–" if value is None else form.format(value)
