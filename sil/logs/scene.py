# SPDX-License-Identifier: MIT
"""What a vessel looks like in a three-dimensional view: a hull, and a ring around its slot."""

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
from matplotlib.colors import to_rgb

from sil.plots import BLACK, colour

# A hull 1 m long, as in the pictures of a run: ahead, to port.
_OUTLINE = ((0.5, 0.0), (0.2, 0.17), (-0.5, 0.14), (-0.5, -0.14), (0.2, -0.17))
_RING_M = 0.3
_FOREVER = Duration(sec=0)
_HERE = Pose(position=Vector3(), orientation=Quaternion(w=1.0))


def of(vessel: str, stamp: Timestamp) -> SceneUpdate:
    """The entities of `vessel`, a name that ends in its number; they move with its frames."""
    red, green, blue = to_rgb(_colour(vessel))
    own = Color(r=red, g=green, b=blue, a=1.0)
    fan = [_OUTLINE[i] for k in range(1, len(_OUTLINE) - 1) for i in (0, k, k + 1)]
    hull = TriangleListPrimitive(
        pose=_HERE, points=[Point3(x=x, y=y, z=0.0) for x, y in fan], color=own
    )
    name = TextPrimitive(
        pose=Pose(position=Vector3(z=0.5), orientation=Quaternion(w=1.0)),
        billboard=True,
        font_size=12.0,
        scale_invariant=True,
        color=own,
        text=vessel,
    )
    angles = [2.0 * pi * k / 24 for k in range(24)]
    ring = LinePrimitive(
        type=LinePrimitiveLineType.LineLoop,
        pose=_HERE,
        thickness=2.0,
        scale_invariant=True,
        points=[Point3(x=_RING_M * cos(a), y=_RING_M * sin(a), z=0.0) for a in angles],
        color=own,
    )
    entity = partial(SceneEntity, timestamp=stamp, lifetime=_FOREVER, frame_locked=True)
    body = entity(frame_id=vessel, id=vessel, triangles=[hull], texts=[name])
    slot = entity(frame_id=f"{vessel}/slot", id=f"{vessel} slot", lines=[ring])
    return SceneUpdate(entities=[body, slot])


def _colour(vessel: str) -> str:
    number = vessel.removeprefix("boat")
    return colour(int(number)) if number.isdecimal() and int(number) else BLACK
