# SPDX-License-Identifier: MIT
"""A vessel's pose, from any of the messages that contain it, and its slot."""

from math import isfinite, nan
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from sil.logs.output import FAR_M, Origin, Output, Pose, frame_of
from sil.wire.axes import aboard, yaw

_LOCAL, _ODOMETRY, _ATTITUDE, _GLOBAL, _FOLLOW, _SLOT = _KINDS = (
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
    mavlink.MAVLINK_MSG_ID_ODOMETRY,
    mavlink.MAVLINK_MSG_ID_ATTITUDE,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
    mavlink.MAVLINK_MSG_ID_FOLLOW_TARGET,
    mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED,
)
_ORIGIN = mavlink.MAVLINK_MSG_ID_GPS_GLOBAL_ORIGIN
MESSAGES = frozenset((*_KINDS, _ORIGIN))
POSES = frozenset((_LOCAL, _ODOMETRY, _GLOBAL, _FOLLOW))
# Most precise first; a less precise message counts once the better ones were silent this long.
_PRECISION = {_ODOMETRY: 0, _LOCAL: 1, _FOLLOW: 2, _GLOBAL: 3}
_TELLS_ATTITUDE = 8
_SILENT_NS = 1_000_000_000


class Track:
    """Writes a vessel's poses; times are the log's, ns. `origin`: its local frame's, if known."""

    def __init__(self, output: Output, vessel: str, origin: Origin | None) -> None:
        self._output = output
        self._vessel = vessel
        self._frame = frame_of(origin) if origin is not None else None
        self._attitude = (nan, nan)
        self._best, self._best_ns = _GLOBAL, 0

    def take(self, t_ns: int, message: Any) -> None:
        """Process a message of MESSAGES; ignores others."""
        kind = message.get_msgId()
        if kind == _ORIGIN:
            self._frame = frame_of(origin_of(message))
        elif kind == _ATTITUDE:
            self._attitude = (message.yaw if isfinite(message.yaw) else nan, message.yawspeed)
        elif kind == _SLOT:
            x, y, _ = self._in_world(message.x, message.y, 0.0)
            self._output.slot(t_ns, self._vessel, x, y)
        elif kind in POSES and self._is_best(t_ns, kind):
            pose = self._pose(kind, message)
            if pose is not None:
                self._output.pose(t_ns, self._vessel, pose)

    def _is_best(self, t_ns: int, kind: int) -> bool:
        if _PRECISION[kind] > _PRECISION[self._best] and t_ns - self._best_ns < _SILENT_NS:
            return False
        self._best, self._best_ns = kind, t_ns
        return True

    def _pose(self, kind: int, message: Any) -> Pose | None:
        if kind == _ODOMETRY:
            return self._of_odometry(message)
        psi, r = self._attitude
        if kind == _LOCAL:
            velocity = message.vx, message.vy
            x, y, turned = self._in_world(message.x, message.y, psi)
            return Pose(x, y, turned, *aboard(psi, *velocity), r)
        world, origin = self._output.world, self._output.origin
        if world is None or origin is None:
            return None
        if kind == _FOLLOW:
            velocity = tuple(message.vel[:2])
            if message.est_capabilities & _TELLS_ATTITUDE:
                psi, r = yaw(*message.attitude_q), message.rates[2]
        else:
            velocity = 0.01 * message.vx, 0.01 * message.vy
        here = frame_of((message.lat, message.lon, origin[2]))
        x, y, turned = here.seen_from(world, 0.0, 0.0, psi)
        return Pose(x, y, turned, *aboard(psi, *velocity), r)

    def _of_odometry(self, message: Any) -> Pose | None:
        """The pose of an ODOMETRY: position in LOCAL_NED, velocity in body axes."""
        frames = (message.frame_id, message.child_frame_id)
        if frames != (mavlink.MAV_FRAME_LOCAL_NED, mavlink.MAV_FRAME_BODY_FRD):
            return None
        x, y, psi = self._in_world(message.x, message.y, yaw(*message.q))
        return Pose(x, y, psi, message.vx, message.vy, message.yawspeed)

    def _in_world(self, x: float, y: float, psi: float) -> tuple[float, float, float]:
        """Convert a pose of the vessel's local frame; without an origin that is the world's frame.

        NaN for an invalid position.
        """
        if not (abs(x) < FAR_M and abs(y) < FAR_M):
            return nan, nan, psi
        world = self._output.world
        if self._frame is None or world is None or self._frame.origin_degE7 == world.origin_degE7:
            return x, y, psi
        return self._frame.seen_from(world, x, y, psi)


def origin_of(message: Any) -> Origin:
    """The origin in a GPS_GLOBAL_ORIGIN."""
    return message.latitude, message.longitude, message.altitude
