# SPDX-License-Identifier: MIT
"""A vessel's reported position, motion and slot. Times are s."""

from math import cos, isfinite, sin
from typing import Any, NamedTuple

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.view.validity import Validity
from sil.wire import mavlink_messages as messages
from sil.wire.axes import aboard, yaw

Origin = tuple[int, int, int]
"""Latitude, longitude (degE7), altitude (mm)."""

_FRESH_S = 1.0
_POSITION, _VELOCITY, _ATTITUDE = 1, 2, 8  # FOLLOW_TARGET's capabilities


class Place(NamedTuple):
    """A position: north and east (m) from an origin, or latitude and longitude (degE7)."""

    t_s: float
    on_globe: bool
    x: float
    y: float


class Motion:
    """The last reported values; None if never reported."""

    def __init__(self) -> None:
        self.origin: Origin | None = None
        self.psi_rad: float | None = None
        self.slot: tuple[float, float] | None = None
        self.slot_valid = Validity()
        self._psi_s = self._velocity_s = 0.0
        self._velocity: tuple[float, float] | None = None  # north, east
        self._local: Place | None = None
        self._globe: Place | None = None

    @property
    def place(self) -> Place | None:
        """The last position: local, unless only global positions still arrive."""
        local, globe = self._local, self._globe
        if local is None or globe is None:
            return local or globe
        return globe if globe.t_s - local.t_s > _FRESH_S else local

    @property
    def body_velocity(self) -> tuple[float | None, float | None]:
        """Velocity over ground ahead and to starboard, m/s; None if unknown."""
        if self._velocity is None or self.psi_rad is None:
            return None, None
        return aboard(self.psi_rad, *self._velocity)

    def forget(self, before_s: float) -> None:
        """Drop a heading and a velocity older than `before_s`."""
        if self._psi_s < before_s:
            self.psi_rad = None
        if self._velocity_s < before_s:
            self._velocity = None

    def hear(self, number: int, fields: tuple[Any, ...], now_s: float) -> None:
        """Process a message of its autopilot."""
        if (take := _TAKE.get(number)) is not None:
            take(self, fields, now_s)

    def _heads(self, psi_rad: float, now_s: float) -> None:
        self.psi_rad, self._psi_s = psi_rad, now_s

    def _moves(self, north: float, east: float, now_s: float) -> None:
        self._velocity, self._velocity_s = (north, east), now_s

    def _attitude(self, f: tuple[Any, ...], now_s: float) -> None:
        if isfinite(f[3]):
            self._heads(f[3], now_s)
        else:
            self.psi_rad = None

    def _local_position(self, f: tuple[Any, ...], now_s: float) -> None:
        if _finite(f[1], f[2], f[4], f[5]):
            self._local = Place(now_s, False, f[1], f[2])
            self._moves(f[4], f[5], now_s)

    def _odometry(self, f: tuple[Any, ...], now_s: float) -> None:
        x, y, q, u, v, frame, child = f[1], f[2], f[4:8], f[8], f[9], f[-5], f[-4]
        if frame != mavlink.MAV_FRAME_LOCAL_NED or not _finite(x, y, *q, u, v):
            return
        self._local = Place(now_s, False, x, y)
        psi = yaw(*q)
        self._heads(psi, now_s)
        c, s = (1.0, 0.0) if child == mavlink.MAV_FRAME_LOCAL_NED else (cos(psi), sin(psi))
        self._moves(c * u - s * v, s * u + c * v, now_s)

    def _global_position(self, f: tuple[Any, ...], now_s: float) -> None:
        if not any(f[1:3]):
            return
        self._globe = Place(now_s, True, f[1], f[2])
        if self._local is None or now_s - self._local.t_s > _FRESH_S:
            self._moves(0.01 * f[5], 0.01 * f[6], now_s)

    def _follow_target(self, f: tuple[Any, ...], now_s: float) -> None:
        north, east, q, capabilities = f[5], f[6], f[11:15], f[-1]
        if not capabilities & _POSITION:
            return
        self._globe = Place(now_s, True, f[2], f[3])
        if capabilities & _VELOCITY and _finite(north, east):
            self._moves(north, east, now_s)
        if capabilities & _ATTITUDE and _finite(*q):
            self._heads(yaw(*q), now_s)

    def _begins(self, f: tuple[Any, ...], _: float) -> None:
        if self.origin != f[:3]:
            if self.origin is not None:
                self._local = self.slot = None  # they were in the old frame
            self.origin = f[0], f[1], f[2]

    def _slot(self, f: tuple[Any, ...], now_s: float) -> None:
        if _finite(f[1], f[2]):
            self.slot = f[1], f[2]
            self.slot_valid.renew(now_s)


def _finite(*numbers: float) -> bool:
    return all(map(isfinite, numbers))


_TAKE = {
    messages.ATTITUDE: Motion._attitude,
    messages.LOCAL_POSITION_NED: Motion._local_position,
    messages.ODOMETRY: Motion._odometry,
    messages.GLOBAL_POSITION_INT: Motion._global_position,
    messages.FOLLOW_TARGET: Motion._follow_target,
    messages.GPS_GLOBAL_ORIGIN: Motion._begins,
    messages.POSITION_TARGET_LOCAL_NED: Motion._slot,
}
