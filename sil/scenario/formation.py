# SPDX-License-Identifier: MIT
"""`[formation]`: defines the boats of a scenario by the shape of their formation."""

import math
from collections.abc import Callable
from typing import Annotated, Any, Literal, get_args

from pydantic import BaseModel, Field, ValidationError

from sil.scenario.sections import Positive, Section
from sil.scenario.toml_errors import ScenarioError, Source, lay, leaves

Shape = Literal["line", "column", "vee", "diamond", "circle", "grid"]
Place = tuple[float, float]


class Formation(Section):
    """Boats in a shape around the virtual leader, all behind it: their slots and their starts.

    "line": abreast; "column": one behind the other, the first at the leader's place; "vee": like
    flying geese; "diamond": a square of boats, one corner ahead; "circle": around the leader, the
    first ahead; "grid": rows abreast, as many boats in a row as rows or one more. If boat 1 leads,
    its place in the shape is the leader's. `spacing_m`: distance between neighbours. `turns`: the
    shape turns with the leader's heading; otherwise every slot keeps its compass bearing from the
    leader.
    """

    shape: Shape
    boats: Annotated[int, Field(ge=1, le=200)]
    spacing_m: Positive
    turns: bool = True


def slots(formation: Formation) -> list[Place]:
    """Slots ahead and to starboard of the leader, m, boat 1 first; ValueError if there are none."""
    return _SHAPES[formation.shape](formation.boats, formation.spacing_m)


class _Led(BaseModel):
    """The leader's place, heading included."""

    eta: tuple[float, float, float] = (0.0, 0.0, 0.0)


class _Shaped(BaseModel):
    """The part of a document that `expand` needs, so that errors name its keys."""

    formation: Formation
    leader: _Led = _Led()
    boat: dict[str, dict[str, Any]] = {}


def expand(source: Source) -> None:
    """Complete a document: its leader's start by its waypoints, its boats by `[formation]`.

    Keys in `[boat.N]` override those of the formation. ScenarioError if the formation is invalid,
    or if a file gives a leader both waypoints and the keys that they replace.
    """
    document = source.document
    leader = document.get("leader")
    if isinstance(leader, dict) and _is_route(leader.get("waypoints")):
        for key in ("eta", "nu", "input"):
            told = [*source.lines, *source.overrides]
            if any(path[:2] == ("leader", key) for path in told):
                raise source.error(
                    ("leader", key),
                    f'"leader.{key}": "leader.waypoints" determines it, leave one of them out',
                )
            leader.pop(key, None)
        first, second = leader["waypoints"][:2]
        leader["eta"] = [*map(float, first), math.atan2(second[1] - first[1], second[0] - first[0])]
    if "formation" not in document:
        return
    if ("boat",) in source.lines:
        raise _listed_too(source)
    parts = {key: document[key] for key in ("formation", "leader", "boat") if key in document}
    if isinstance(parts.get("boat"), list):
        del parts["boat"]  # the base's boats, which those of the formation replace
    try:
        shaped = _Shaped.model_validate(parts)
    except ValidationError as error:
        raise source.errors(error, _Shaped) from None
    try:
        boats = boats_of(shaped.formation, leader if isinstance(leader, dict) else {})
    except ValueError as error:
        raise source.error(("formation",), f'"formation": {error}') from None
    for number, changes in shaped.boat.items():
        if not number.isdecimal() or not 1 <= int(number) <= len(boats):
            raise source.error(
                ("boat", number), f'"boat.{number}": the number must be from 1 to {len(boats)}'
            )
        for path, value in leaves(changes):
            try:
                lay(boats[int(number) - 1], path, value)
            except LookupError as error:
                at = ("boat", number, *path)
                raise source.error(at, f'"{".".join(at)}": {error.args[0]}') from None
    document["boat"] = boats


def _listed_too(source: Source) -> ScenarioError:
    """The file has a list of boats as well."""
    if any(path[0] == "formation" for path in source.lines):
        why = '"boat": [formation] creates the boats; use [boat.2] to change one'
        return source.error(("boat",), why)
    why = "the file lists its boats in [[boat]]: change those, or choose a file with [formation]"
    return source.error(("formation",), f'"formation": {why}')


def _is_route(points: Any) -> bool:
    """Whether `points` has two places or more; if not, the scenario's own check reports it."""
    return (
        isinstance(points, list)
        and len(points) > 1
        and all(
            isinstance(point, list)
            and len(point) == 2
            and all(isinstance(x, int | float) for x in point)
            for point in points
        )
    )


def boats_of(formation: Formation, leader: dict[str, Any]) -> list[dict[str, Any]]:
    """The tables of the scenario's boats, at rest in their slots with the leader's heading.

    `leader`: its table. ValueError as `slots`.
    """
    north, east, course = leader.get("eta", (0.0, 0.0, 0.0))
    cos, sin = math.cos(course), math.sin(course)
    places = slots(formation)
    if leader.get("boat") == 1:
        places = [(x - places[0][0], y - places[0][1]) for x, y in places]
    boats = []
    for ahead, starboard in places:
        turned = (cos * ahead - sin * starboard, sin * ahead + cos * starboard)
        offset = (ahead, starboard) if formation.turns else turned
        boats.append(
            {
                "follows": 0,
                "offset_m": list(offset),
                "eta": [north + turned[0], east + turned[1], course],
                "parameters": {"FORM_FRAME": 1.0} if formation.turns else {},
            }
        )
    return boats


def _line(boats: int, spacing_m: float) -> list[Place]:
    return [(0.0, spacing_m * (i - 0.5 * (boats - 1))) for i in range(boats)]


def _column(boats: int, spacing_m: float) -> list[Place]:
    return [(-spacing_m * i, 0.0) for i in range(boats)]


def _vee(boats: int, spacing_m: float) -> list[Place]:
    step = spacing_m * math.sqrt(0.5)
    rows = [((i + 1) // 2, -1 if i % 2 else 1) for i in range(boats)]
    return [(-step * row, side * step * row) for row, side in rows]


def _diamond(boats: int, spacing_m: float) -> list[Place]:
    side = math.isqrt(boats)
    if side * side != boats:
        near = f"{side * side} or {(side + 1) ** 2}"
        raise ValueError(f"a diamond has 1, 4, 9, 16 … boats: use {near} instead of {boats}")
    step = spacing_m * math.sqrt(0.5)
    return [(step * (side - 1 - i - j), step * (i - j)) for i in range(side) for j in range(side)]


def _circle(boats: int, spacing_m: float) -> list[Place]:
    radius = 0.5 * spacing_m / math.sin(math.pi / boats) if boats > 1 else 0.0
    angles = [2.0 * math.pi * i / boats for i in range(boats)]
    return [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles]


def _grid(boats: int, spacing_m: float) -> list[Place]:
    columns = math.isqrt(boats - 1) + 1
    middle = 0.5 * (columns - 1)
    return [(-spacing_m * (i // columns), spacing_m * (i % columns - middle)) for i in range(boats)]


_SHAPES: dict[Shape, Callable[[int, float], list[Place]]] = {
    "line": _line,
    "column": _column,
    "vee": _vee,
    "diamond": _diamond,
    "circle": _circle,
    "grid": _grid,
}
assert set(_SHAPES) == set(get_args(Shape))
