# SPDX-License-Identifier: MIT
"""A vessel in three-dimensional views: a hull, and a ring around its slot."""

from functools import partial
from math import cos, pi, sin

from foxglove.messages import (
    Color,
    Duration,
    LinePrimitive,
    LinePrimitiveLineType,
    Point3,
    Pose,
    Quaternion,
    SceneEntity,
    SceneUpdate,
    TextPrimitive,
    Timestamp,
    TriangleListPrimitive,
    Vector3,
)

from sil.common.colours import BLACK, colour_of

# Outline of a hull 1 m long, as in a run's pictures: ahead, to port.
_OUTLINE = ((0.5, 0.0), (0.2, 0.17), (-0.5, 0.14), (-0.5, -0.14), (0.2, -0.17))
_RING_M, _CORNERS = 0.3, 24
_FOREVER = Duration(sec=0)
_HERE = Pose(position=Vector3(), orientation=Quaternion(w=1.0))


def of(vessel: str, stamp: Timestamp, *, with_slot: bool) -> SceneUpdate:
    """The entities of `vessel`, whose name ends in its number; they move with its frames."""
    own = _colour(vessel)
    entity = partial(SceneEntity, timestamp=stamp, lifetime=_FOREVER, frame_locked=True)
    entities = [entity(frame_id=vessel, id=vessel, triangles=[_hull(own)], texts=[_name(vessel)])]
    if with_slot:
        slot = f"{vessel}/slot"
        entities.append(entity(frame_id=slot, id=slot, lines=[_ring(own)]))
    return SceneUpdate(entities=entities)


def _colour(vessel: str) -> Color:
    number = vessel.removeprefix("boat")
    known = number.isdecimal() and int(number)
    code = colour_of(int(number)) if known else BLACK  # "#rrggbb"
    red, green, blue = (part / 255.0 for part in bytes.fromhex(code[1:]))
    return Color(r=red, g=green, b=blue, a=1.0)


def _hull(own: Color) -> TriangleListPrimitive:
    fan = [_OUTLINE[i] for k in range(1, len(_OUTLINE) - 1) for i in (0, k, k + 1)]
    points = [Point3(x=x, y=y, z=0.0) for x, y in fan]
    return TriangleListPrimitive(pose=_HERE, points=points, color=own)


def _name(vessel: str) -> TextPrimitive:
    above = Pose(position=Vector3(z=0.5), orientation=Quaternion(w=1.0))
    text = partial(TextPrimitive, billboard=True, font_size=12.0, scale_invariant=True)
    return text(pose=above, color=_colour(vessel), text=vessel)


def _ring(own: Color) -> LinePrimitive:
    angles = [2.0 * pi * k / _CORNERS for k in range(_CORNERS)]
    return LinePrimitive(
        type=LinePrimitiveLineType.LineLoop,
        pose=_HERE,
        thickness=2.0,
        scale_invariant=True,
        points=[Point3(x=_RING_M * cos(a), y=_RING_M * sin(a), z=0.0) for a in angles],
        color=own,
    )
