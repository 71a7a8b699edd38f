# SPDX-License-Identifier: MIT
"""Writes an MCAP file: the vessels' topics, in Foxglove's schemas and ours.

Poses are north-east-down, as everywhere here. For three-dimensional views (`/tf`, scenes) they are
converted to x east, y north, z up, and in the vessel to x ahead, y port, z up. Times are UNIX, ns.
"""

import io
from math import cos, isfinite, nan, pi, sin
from pathlib import Path
from typing import Any, NamedTuple

import foxglove
from foxglove.channels import (
    FrameTransformsChannel,
    LocationFixChannel,
    LogChannel,
    SceneUpdateChannel,
)
from foxglove.messages import (
    FrameTransform,
    FrameTransforms,
    LocationFix,
    Log,
    LogLevel,
    Quaternion,
    Timestamp,
    Vector3,
)

from sil.common import files
from sil.logs import scene, schema
from sil.wire.geodesy import LocalFrame

WORLD = "world"
FAR_M = 1e7  # farther positions count as invalid
_SECOND_NS = 1_000_000_000

#: Origin of a local frame: latitude and longitude (degE7), altitude (mm).
Origin = tuple[int, int, int]


def frame_of(origin: Origin) -> LocalFrame:
    """The local frame with this origin."""
    return LocalFrame(*origin[:2], 0.001 * origin[2])


class Pose(NamedTuple):
    """A vessel's pose in the world's frame and its velocity in body axes."""

    x_m: float
    y_m: float
    psi_rad: float
    u_mps: float = nan
    v_mps: float = nan
    r_radps: float = nan


class Output:
    """Collects messages in memory until `write`. A context manager.

    `origin`: origin of the world's frame (degE7, degE7, mm); None if unknown: then there are no
    LocationFix messages.
    """

    def __init__(self, origin: Origin | None) -> None:
        self.origin = origin
        self.world = None if origin is None else frame_of(origin)
        self._context = foxglove.Context()
        self._buffer = io.BytesIO()
        self._writer = foxglove.open_mcap(self._buffer, context=self._context)
        self._transforms = FrameTransformsChannel("/tf", context=self._context)
        self._fixes: dict[str, LocationFixChannel] = {}
        self._own: dict[str, foxglove.Channel] = {}
        self._logs: dict[str, LogChannel] = {}
        self._scenes: dict[str, SceneUpdateChannel] = {}
        self._with_slot: set[str] = set()
        self.messages = 0
        self.vessels: set[str] = set()

    def __enter__(self) -> "Output":
        return self

    def __exit__(self, *_: object) -> None:
        self._writer.close()

    def write(self, path: Path) -> None:
        """Finish the file and write it atomically."""
        self._writer.close()
        files.replace(path, self._buffer.getvalue())

    def pose(self, t_ns: int, vessel: str, pose: Pose) -> None:
        """Write `/VESSEL/state`, `/VESSEL/fix` and `/tf`, with the first pose also the scene.

        Skips positions that are not finite or farther than FAR_M; without a heading, skips `/tf`.
        """
        if not (abs(pose.x_m) < FAR_M and abs(pose.y_m) < FAR_M):
            return
        if vessel not in self._scenes:
            self._draw(t_ns, vessel)
        self.own(t_ns, f"/{vessel}/state", "State", pose._asdict())
        if isfinite(pose.psi_rad):
            self._transform(t_ns, vessel, pose.x_m, pose.y_m, pose.psi_rad)
        self._fix(t_ns, vessel, pose)

    def slot(self, t_ns: int, vessel: str, x_m: float, y_m: float) -> None:
        """Write a vessel's slot, north and east of the world's origin, to `/tf`."""
        if not (abs(x_m) < FAR_M and abs(y_m) < FAR_M):
            return
        if vessel not in self._with_slot:
            self._with_slot.add(vessel)
            self._draw(t_ns, vessel)
        self._transform(t_ns, f"{vessel}/slot", x_m, y_m, 0.0)

    def own(self, t_ns: int, topic: str, name: str, values: dict[str, Any]) -> None:
        """Write a message of our own schema: `name` and `values` as in `sil.logs.schema`."""
        channel = self._own.get(topic)
        if channel is None:
            self.vessels.add(topic.split("/")[1])
            channel = self._own[topic] = foxglove.Channel(
                topic,
                schema=schema.schema(name),
                message_encoding="protobuf",
                context=self._context,
            )
        channel.log(schema.encode(name, values), log_time=t_ns)
        self.messages += 1

    def log(self, t_ns: int, vessel: str, level: LogLevel, text: str) -> None:
        """Write a vessel's text or change of state to `/VESSEL/log`."""
        line = Log(timestamp=_stamp(t_ns), level=level, message=text, name=vessel)
        if vessel not in self._logs:
            self._logs[vessel] = LogChannel(f"/{vessel}/log", context=self._context)
        self._logs[vessel].log(line, log_time=t_ns)
        self.messages += 1

    def _fix(self, t_ns: int, vessel: str, pose: Pose) -> None:
        if self.origin is None or self.world is None:
            return
        latitude, longitude, _ = self.world.geodetic(pose.x_m, pose.y_m, pose.psi_rad)
        fix = LocationFix(
            timestamp=_stamp(t_ns),
            frame_id=vessel,
            latitude=1e-7 * latitude,
            longitude=1e-7 * longitude,
            altitude=0.001 * self.origin[2],
        )
        if vessel not in self._fixes:
            self._fixes[vessel] = LocationFixChannel(f"/{vessel}/fix", context=self._context)
        self._fixes[vessel].log(fix, log_time=t_ns)
        self.messages += 1

    def _transform(self, t_ns: int, child: str, x_m: float, y_m: float, psi: float) -> None:
        half = 0.5 * (0.5 * pi - psi)
        transform = FrameTransform(
            timestamp=_stamp(t_ns),
            parent_frame_id=WORLD,
            child_frame_id=child,
            translation=Vector3(x=y_m, y=x_m, z=0.0),
            rotation=Quaternion(x=0.0, y=0.0, z=sin(half), w=cos(half)),
        )
        self._transforms.log(FrameTransforms(transforms=[transform]), log_time=t_ns)
        self.messages += 1

    def _draw(self, t_ns: int, vessel: str) -> None:
        """Write the whole scene, even if only the slot is new: a viewer may show only the last."""
        if vessel not in self._scenes:
            self._scenes[vessel] = SceneUpdateChannel(f"/{vessel}/scene", context=self._context)
        drawn = scene.of(vessel, _stamp(t_ns), with_slot=vessel in self._with_slot)
        self._scenes[vessel].log(drawn, log_time=t_ns)
        self.messages += 1


def _stamp(t_ns: int) -> Timestamp:
    return Timestamp(sec=t_ns // _SECOND_NS, nsec=t_ns % _SECOND_NS)
