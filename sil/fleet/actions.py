# SPDX-License-Identifier: MIT
"""An operator's actions on a fleet, each with its messages and exit status: 0 done, 1 not."""

import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

from rich.console import Console

from sil.fleet import fleet_status
from sil.fleet.lead import leading_boat, root
from sil.fleet.orders import (
    DISCOVERY_S,
    IS_DISARMED,
    RESTS,
    Answer,
    Order,
    carry_out,
    go_to,
    long,
    stop,
    tell,
)
from sil.fleet.shape_change import change
from sil.fleet.station import STALE_S, Station
from sil.fleet.tables import epoch_at, told_epochs, warnings_of
from sil.view.seen_table import listed
from sil.wire.geodesy import LocalFrame
from sil.wire.heartbeat import AUTO, FORMATION, HOLD, LOITER, RTL
from sil.wire.operator import ARM, DISARM, mode_request

_STATUS_S, _NAMED_S = 3.0, 4.0


class Wish(NamedTuple):
    """A requested action and its boats; `boats` empty: all boats heard.

    `place`: latitude and longitude, deg; `way_m`: metres north and east of the leader's position.
    """

    action: str
    boats: tuple[int, ...] = ()
    shape: str = ""
    spacing_m: float | None = None
    turning: bool = True
    place: tuple[float, float] | None = None
    way_m: tuple[float, float] | None = None


def perform(station: Station, wish: Wish, console: Console) -> int:
    """Execute the action, print the result, return the exit status; ValueError if impossible."""
    if wish.action == "stop":
        return _stop(station, wish, console)
    boats = discover(station, wish)
    if not boats:
        show(console, _nobody(station), "bold red")
        return 1
    status = _ACTIONS[wish.action](station, wish, boats, console)
    _warn_of_time(station, console)
    return status


def show(console: Console, words: str, style: str = "") -> None:
    """Print a line as it is: a boat's text may look like rich's markup."""
    console.print(words, style=style, markup=False, emoji=False, soft_wrap=True)


def discover(station: Station, wish: Wish) -> list[int]:
    """The boats that are named, or all boats heard meanwhile."""
    named = list(wish.boats)
    if wish.action in ("status", "go") or not named:  # "go" needs their places
        least_s = _STATUS_S if wish.action == "status" else DISCOVERY_S
        station.run(least_s - station.now_s())
    else:
        station.run(_NAMED_S, lambda: set(named) <= set(station.boats()))
    return named if named and station.boats() else station.boats()


def _nobody(station: Station) -> str:
    if station.late_s:
        return _of_time(station)
    if station.refused:
        return f"no boat signs with this key: {station.refused} messages refused; check --key"
    others = sorted(station.fleet.systems)
    heard = f"; heard, but not boats: {', '.join(map(str, others))}" if others else ""
    return f"no boat is heard: check the boats' power, the address and the radio{heard}"


def _of_time(station: Station) -> str:
    whose, late_s = listed(sorted(station.late_s)), max(station.late_s.values())
    return (
        f"{whose}: signed with this key, but the time differs by {late_s:.0f} s from this "
        "computer's: set the clock that is wrong (timedatectl)"
    )


def _warn_of_time(station: Station, console: Console) -> None:
    if station.late_s:
        show(console, _of_time(station), "bold yellow")


def _status(station: Station, _: Wish, boats: Sequence[int], console: Console) -> int:
    words, rows, complete = fleet_status.of_station(station, boats)
    show(console, words, "bold")
    console.print(rows)
    return 0 if complete else 1


def _stop(station: Station, wish: Wish, console: Console) -> int:
    answers = stop(station, wish.boats)
    asked = [answer.system for answer in answers]
    strangers = [boat for boat in station.strangers() if boat not in asked]
    if not answers and not strangers:
        show(console, _nobody(station), "bold red")
        return 1
    for warning in warnings_of(told_epochs(station, asked), epoch_at(station.unix_s())):
        show(console, warning, "bold yellow")
    status = _report(station, answers, "stopped and disarmed", console)
    for boat in strangers:
        why = f"is heard, but does not say that it runs Flotilla: --boats {boat} stops it"
        show(console, f"boat {boat} {why}", "bold red")
    _warn_of_time(station, console)
    return 1 if strangers else status


def _to_all(order: Order, done: str, states: Sequence[str] = ()) -> Callable[..., int]:
    def act(station: Station, _: Wish, boats: Sequence[int], console: Console) -> int:
        return _report(station, carry_out(station, order, boats, states), done, console)

    return act


def _to_leader(order: Order, done: str) -> Callable[..., int]:
    def act(station: Station, wish: Wish, _: Sequence[int], console: Console) -> int:
        return _lead(station, wish, order, done, console)

    return act


def _lead(station: Station, wish: Wish, order: Order, done: str, console: Console) -> int:
    if len(wish.boats) > 1:
        raise ValueError(f"{wish.action} commands only the leader: name one boat")
    boat = wish.boats[0] if wish.boats else leading_boat(station)
    status = _report(station, carry_out(station, order, [boat]), done, console)
    if status == 0:
        show(console, f"boat {boat} leads; the others follow it and received no command")
    return status


def _follow(station: Station, wish: Wish, boats: Sequence[int], console: Console) -> int:
    top = None if wish.boats else root(station)
    followers = [boat for boat in boats if boat != top]
    answers = carry_out(station, long(mode_request(FORMATION)), followers)
    vessel = None if top is None else station.fleet.systems.get(top)
    if vessel is not None and vessel.kind == "boat" and vessel.state not in fleet_status.LEADING:
        show(console, f"boat {top} does not lead yet: start it with auto, go or loiter")
    return _report(station, answers, "in FORMATION", console)


def _go(station: Station, wish: Wish, _: Sequence[int], console: Console) -> int:
    if wish.place is not None:
        latitude, longitude = wish.place
    else:
        boat = wish.boats[0] if wish.boats else leading_boat(station)
        latitude, longitude = place_of(station, boat, wish.way_m or (0.0, 0.0))
    order = go_to(round(1e7 * latitude), round(1e7 * longitude))
    return _lead(station, wish, order, f"sails to {latitude:.6f} {longitude:.6f}", console)


def place_of(station: Station, boat: int, way_m: tuple[float, float]) -> tuple[float, float]:
    """Latitude and longitude, deg, at `way_m` from a boat; ValueError if the boat is lost."""
    told = {vessel["id"]: vessel for vessel in station.fleet.vessels(station.now_s())}
    origin, vessel = station.fleet.origin, told.get(boat)
    lost = vessel is None or vessel["x_m"] is None or vessel["place_age_s"] >= STALE_S
    if origin is None or vessel is None or lost:
        raise ValueError(f"boat {boat} reports no recent position")
    frame = LocalFrame(*origin[:2], 0.001 * origin[2])
    place = frame.geodetic(vessel["x_m"] + way_m[0], vessel["y_m"] + way_m[1], 0.0)
    return 1e-7 * place.latitude, 1e-7 * place.longitude


def _form(station: Station, wish: Wish, boats: Sequence[int], console: Console) -> int:
    made = change(station, boats, wish.shape, wish.spacing_m, turning=wish.turning)
    show(console, made.words, "bold")
    for boat, (ahead_m, starboard_m) in zip(boats, made.places, strict=False):
        show(console, f"  boat {boat}: {_place(ahead_m, starboard_m, turning=wish.turning)}")
    for warning in made.warnings:
        show(console, warning, "bold yellow")
    for boat, why in made.missing.items():
        show(console, f"boat {boat}: {why}", "bold red")
    return 1 if made.missing else 0


def _place(ahead_m: float, starboard_m: float, *, turning: bool) -> str:
    names = (("ahead", "astern"), ("to starboard", "to port"))
    if not turning:
        names = (("north", "south"), ("east", "west"))
    ways = zip((ahead_m, starboard_m), names, strict=True)
    told = [f"{abs(way):.1f} m {name[way < 0]}" for way, name in ways if abs(way) >= 0.05]
    return ", ".join(told) or "leads"


def _report(station: Station, answers: Sequence[Answer], done: str, console: Console) -> int:
    good = [answer for answer in answers if answer.accepted]
    show(console, f"{len(good)} of {len(answers)} {done}", "bold")
    for answer in answers:
        if answer.accepted:
            for text in answer.said:
                if ", no FORMATION: " in text:
                    show(console, f"  boat {answer.system}: {text}")
            continue
        vessel = station.fleet.systems.get(answer.system)
        held = () if vessel is None else vessel.held()
        why = tell(answer, held, answer.system in station.signs)
        heard = station.is_heard(answer.system) or answer.system in station.late_s
        if answer.result is None and not heard and not answer.only_listed:
            why += ", and it is not heard"
        show(console, f"boat {answer.system}: {why}", "bold red")
    return 0 if len(good) == len(answers) else 1


def is_on_globe(latitude: float, longitude: float) -> bool:
    """Whether latitude and longitude, deg, are valid."""
    finite = math.isfinite(latitude) and math.isfinite(longitude)
    return finite and abs(latitude) <= 90.0 and abs(longitude) <= 180.0


_ACTIONS: dict[str, Callable[[Station, Wish, Sequence[int], Console], int]] = {
    "status": _status,
    "arm": _to_all(long(ARM), "armed"),
    "disarm": _to_all(long(DISARM), "disarmed", IS_DISARMED),
    "hold": _to_all(long(mode_request(HOLD)), "in HOLD", RESTS),
    "form": _form,
    "follow": _follow,
    "go": _go,
    "loiter": _to_leader(long(mode_request(LOITER)), "waits in LOITER"),
    "return": _to_leader(long(mode_request(RTL)), "returns"),
    "auto": _to_leader(long(mode_request(AUTO)), "sails its plan"),
}
