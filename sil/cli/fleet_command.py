# SPDX-License-Identifier: MIT
"""Commands a whole fleet: arms it, forms it, sends it off, stops it.

status            which boats are in their slots, which boat leads, which are silent
arm, disarm       all boats, or those of --boats
form SHAPE        a new shape: line, column, vee, diamond, circle or grid with --spacing M,
                  or a file NAME.toml with places_m = [[ahead, starboard], …]; the first of --boats
                  (or the lowest system id) leads
follow            FORMATION for all that follow
auto              the leader begins its plan
go LAT LON        the leader sails there and waits; --local N E: metres north and east of itself
loiter, return    the leader waits, or comes home; the fleet follows it
hold              all boats stop their propellers and stay armed
stop              disarms every boat directly, by every link; names each that did not answer
serve             makes the fleet one vehicle, with the system id --as, for a ground station
                  at --ground, until Ctrl-C

Exit status: 0; 1 if a boat did not execute its command; 2 after a mistake of the caller.
"""

import argparse
import difflib
from collections.abc import Sequence
from contextlib import closing
from functools import partial
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from sil.fleet.actions import Wish
    from sil.fleet.station import Station

EXAMPLES = (
    "flotilla fleet status",
    "flotilla fleet form vee --spacing 5 --boats 1,2,3,4",
    "flotilla fleet go --local 20 -5",
    "flotilla fleet --mavlink udpin:0.0.0.0:14550 --key key stop",
    "flotilla fleet --mavlink tcp:127.0.0.1:5760 --mavlink tcp:127.0.0.1:5770 arm",
    "flotilla fleet serve --as 250 --ground udpout:127.0.0.1:14551",
)

_WORDS = {"form": "SHAPE", "go": "LAT LON"}
_ACTIONS = (
    "status",
    "arm",
    "disarm",
    "form",
    "follow",
    "auto",
    "go",
    "loiter",
    "return",
    "hold",
    "stop",
    "serve",
)
_AT_ONCE = ("stop", "hold", "disarm")  # never refused for an option too many
_DEFAULT, _GROUND = "udpin:127.0.0.1:14550", "udpout:127.0.0.1:14551"
_VEHICLE = 250  # the fleet's system id


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("action", metavar="ACTION", help="one of the actions above")
    parser.add_argument("words", nargs="*", metavar="…", help="SHAPE, or LAT LON")
    parser.add_argument(
        "--mavlink",
        action="append",
        metavar="udpin:HOST:PORT|udpout:HOST:PORT|tcp:HOST:PORT|/dev/TTY[:BAUD]",
        help=f"a link to the boats ({_DEFAULT}); repeatable",
    )
    parser.add_argument(
        "--boats", type=_systems, default=(), metavar="N,N", help="system ids (all boats heard)"
    )
    parser.add_argument(
        "--key",
        type=Path,
        metavar="FILE",
        help="sign messages, and accept only those signed with this key",
    )
    parser.add_argument(
        "--station", type=_system, default=255, metavar="N", help="system id of this station (255)"
    )
    parser.add_argument(
        "--spacing", type=float, metavar="M", help="form: distance between neighbours, m"
    )
    parser.add_argument(
        "--fixed", action="store_true", help="form: the shape does not turn; ahead is north"
    )
    parser.add_argument(
        "--local",
        nargs=2,
        type=float,
        metavar=("N", "E"),
        help="go: metres north and east of the leader",
    )
    parser.add_argument("--ground", metavar="LINK", help=f"serve: the ground station ({_GROUND})")
    parser.add_argument(
        "--as",
        type=_system,
        metavar="N",
        dest="vehicle",
        help=f"serve: system id of the fleet's vehicle ({_VEHICLE})",
    )


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Execute the action."""
    wish = _wish(options)
    from rich.console import Console

    from sil.fleet.actions import perform, show
    from sil.fleet.ends import end_at
    from sil.fleet.station import LINK, Station
    from sil.wire.signing import Signer, read_key

    signer = None if options.key is None else Signer(read_key(options.key), LINK)
    ends = []
    try:
        for address in options.mavlink or [_DEFAULT]:
            ends.append(end_at(address))
    except (OSError, ValueError):
        for end in ends:
            end.close()
        raise
    console = Console(highlight=False)
    with closing(Station(ends, options.station, signer)) as station:
        station.told = partial(show, console)
        if wish.action == "serve":
            return _serve(station, options, console)
        return perform(station, wish, console)


def _serve(station: "Station", options: argparse.Namespace, console: "Console") -> int:
    from sil.fleet.actions import show
    from sil.fleet.ends import end_at
    from sil.fleet.fleet_vehicle import LINK, FleetVehicle
    from sil.wire.signing import Signer, read_key

    signer = None if options.key is None else Signer(read_key(options.key), LINK)
    ground, system = options.ground or _GROUND, options.vehicle or _VEHICLE
    with closing(end_at(ground, "--ground")) as end:
        tell = partial(show, console)
        vehicle = FleetVehicle(station, end, system, signer, tell)
        tell(f"the fleet is vehicle {system} at {ground}; Ctrl-C ends it")
        while True:
            vehicle.serve(for_s=3600.0)


def _wish(options: argparse.Namespace) -> "Wish":
    """Translate the options into a wish; ValueError if they contradict each other."""
    action, words = options.action, options.words
    if action not in _ACTIONS:
        near = difflib.get_close_matches(action, _ACTIONS, 1)
        hint = f'; did you mean "{near[0]}"?' if near else f": {', '.join(_ACTIONS)}"
        raise ValueError(f'unknown action "{action}"{hint}')
    for option, given, of in (
        ("--spacing", options.spacing is not None, "form"),
        ("--fixed", options.fixed, "form"),
        ("--local", options.local is not None, "go"),
        ("--ground", options.ground is not None, "serve"),
        ("--as", options.vehicle is not None, "serve"),
    ):
        if given and action not in (of, *_AT_ONCE):
            raise ValueError(f"{option} belongs to {of}, not to {action}")
    from sil.fleet.actions import Wish, is_on_globe
    from sil.fleet.tables import check_shape

    wanted = {"form": 1, "go": 0 if options.local else 2}.get(action, 0)
    if len(words) != wanted:
        usage = f"flotilla fleet {action} {_WORDS.get(action, '')}".rstrip()
        raise ValueError(f"{usage}: arguments needed: {wanted}, given: {len(words)}")
    if action == "form":
        check_shape(words[0], options.spacing)
    if options.local and not all(map(isfinite, options.local)):
        raise ValueError("--local: both must be finite numbers of metres")
    place = None
    if action == "go" and not options.local:
        try:
            place = float(words[0]), float(words[1])
        except ValueError:
            raise ValueError(
                f'"{" ".join(words)}" is not a latitude and longitude in degrees'
            ) from None
        if not is_on_globe(*place):
            raise ValueError(
                f'"{" ".join(words)}": latitude must be from -90 to 90 degrees, '
                "longitude from -180 to 180"
            )
    return Wish(
        action=action,
        boats=options.boats,
        shape=words[0] if action == "form" else "",
        spacing_m=options.spacing,
        turning=not options.fixed,
        place=place,
        way_m=None if options.local is None else tuple(options.local),
    )


def _system(text: str) -> int:
    """Parse a system id; raise an argparse error if it is invalid."""
    if not text.isdecimal() or not 1 <= int(text) <= 255:
        raise argparse.ArgumentTypeError(f'"{text}" is not a system id (1 to 255)')
    return int(text)


def _systems(text: str) -> tuple[int, ...]:
    systems = tuple(_system(part.strip()) for part in text.split(","))
    if len(set(systems)) < len(systems):
        raise argparse.ArgumentTypeError(f'"{text}" names a boat twice')
    return systems
