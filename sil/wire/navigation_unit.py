# SPDX-License-Identifier: MIT
"""The MAVLink side of a navigation unit: sends state, origin and heartbeats, answers TIMESYNC.

Used for a boat's own unit (with the boat's system id) and for the virtual leader. Frames:
north-east-down, heading clockwise from north; body x forward, y starboard.
Source: mavlink.io, common message set.
"""

from collections import Counter, deque
from collections.abc import Sequence
from math import cos, nan, pi, remainder, sin, tau
from typing import Any, Literal, NamedTuple

from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.wire.geodesy import LocalFrame
from sil.wire.mavlink_frames import frames
from sil.wire.rate import Rate
from sil.wire.state_frame import StateFrame

_TIMESYNC: int = mavlink.MAVLINK_MSG_ID_TIMESYNC
_UNKNOWN_COVARIANCE = [nan] + [0.0] * 20
_UNKNOWN_HEADING = 65535
_FOLLOW_CAPABILITIES = 1 | 2 | 8  # position, velocity, attitude and rates

Message = Literal["local", "odometry", "global", "follow_target"]


class Settings(NamedTuple):
    """A unit's messages and rates; `attitude_rate_hz` 0: ATTITUDE with every position.

    `origin_m`: origin of its local frame, north and east of the world's. `delay_s`: latency of its
    messages; their time stamps are those of the measurement. `timesync`: whether it answers
    TIMESYNC, which it then does without that latency. Once every `dropout_every_s` (0: never) of
    its clock it sends no state for `dropout_s`.
    """

    rate_hz: float
    message: Message = "local"
    attitude_rate_hz: float = 0.0
    origin_m: tuple[float, float] = (0.0, 0.0)
    delay_s: float = 0.0
    timesync: bool = True
    dropout_every_s: float = 0.0
    dropout_s: float = 0.0


def _wrap(psi: float) -> float:
    psi = remainder(psi, tau)
    return psi if psi > -pi else pi


class NavigationUnit:
    """One sender of state; times are of its own clock (us, positive).

    `origin` is (latitude degE7, longitude degE7, altitude mm) of the world's frame, the tangent
    plane in which eta is given; vessels are at sea level. `counters` counts received `timesync`
    requests and `bad` frames (wrong CRC).
    """

    def __init__(
        self,
        system_id: int,
        component_id: int,
        *,
        vehicle_type: int,
        origin: tuple[int, int, int],
        settings: Settings,
    ) -> None:
        self.counters: Counter[str] = Counter()
        self._mav = mavlink.MAVLink(None, system_id, component_id)
        self._attitude, self._position = (
            StateFrame(message_class, system_id, component_id)
            for message_class in (
                mavlink.MAVLink_attitude_message,
                mavlink.MAVLink_local_position_ned_message,
            )
        )
        self._vehicle_type = vehicle_type
        self._world = LocalFrame(*origin[:2], 0.001 * origin[2])
        self._frame = self._world.moved(*settings.origin_m) if any(settings.origin_m) else None
        self._origin = (*self._frame.origin_degE7, origin[2]) if self._frame else origin
        self._state = {
            "local": self._local,
            "odometry": self._odometry,
            "global": self._global,
            "follow_target": self._follow_target,
        }[settings.message]
        self._state_rate = Rate(settings.rate_hz)
        self._attitude_rate = Rate(settings.attitude_rate_hz) if settings.attitude_rate_hz else None
        self._slow_rate = Rate(1.0)
        self._requests: list[tuple[int, int]] = []
        self._answers_timesync = settings.timesync
        self._delay_us, self._every_us, self._dropout_us = (
            round(1e6 * s) for s in (settings.delay_s, settings.dropout_every_s, settings.dropout_s)
        )
        self._waiting: deque[tuple[int, bytes]] = deque()

    def tick(self, now_us: int, eta: Sequence[float], nu: Sequence[float]) -> bytes:
        """The messages due now, for eta = [x y psi] (m, m, rad), nu = [u v r] (m/s, m/s, rad/s)."""
        out = b""
        if self._slow_rate.due(now_us):
            out = self._heartbeat() + self._pack(
                mavlink.MAVLink_gps_global_origin_message(*self._origin, now_us)
            )
        if not self._delay_us:
            return out + self._answers() + self._told(now_us, eta, nu)
        self._waiting.append((now_us, out + self._told(now_us, eta, nu)))
        out = self._answers()
        # A message from the future, after the clock was set back, leaves at once.
        while self._waiting and not 0 <= now_us - self._waiting[0][0] < self._delay_us:
            out += self._waiting.popleft()[1]
        return out

    def _answers(self) -> bytes:
        out = b""
        for ts1, arrived_us in self._requests:
            # The time of arrival, not of the answer: the requester bounds our clock by it.
            out += self._pack(mavlink.MAVLink_timesync_message(1000 * arrived_us, ts1))
        self._requests.clear()
        return out

    def _told(self, now_us: int, eta: Sequence[float], nu: Sequence[float]) -> bytes:
        """The state messages that are due; none during a drop-out."""
        attitude = self._attitude_rate is not None and self._attitude_rate.due(now_us)
        state = self._state_rate.due(now_us)
        if self._every_us and now_us % self._every_us >= self._every_us - self._dropout_us:
            return b""
        out = self._attitude_frame(now_us, eta, nu) if attitude else b""
        return out + self._state(now_us, eta, nu) if state else out

    def on_mavlink(self, data: bytes, now_us: int) -> None:
        """Process any bytes; TIMESYNC requests to this unit are answered by the next tick."""
        for message_id, _, _, frame in frames(data):
            if message_id != _TIMESYNC or not self._answers_timesync:
                continue
            try:
                request = self._mav.decode(bytearray(frame))
            except mavlink.MAVError:
                self.counters["bad"] += 1
                continue
            # Target ids, a newer extension that the wheel's dialect lacks; trailing zeros are cut.
            target = frame[26 : 10 + frame[1]]
            own = (self._mav.srcSystem, self._mav.srcComponent)
            if request.tc1 == 0 and all(t in (0, o) for t, o in zip(target, own, strict=False)):
                self.counters["timesync"] += 1
                self._requests.append((request.ts1, now_us))

    def _pack(self, message: Any) -> bytes:
        frame: bytes = message.pack(self._mav)
        self._mav.seq = (self._mav.seq + 1) & 0xFF
        return frame

    def _heartbeat(self) -> bytes:
        return self._pack(
            mavlink.MAVLink_heartbeat_message(
                self._vehicle_type,
                mavlink.MAV_AUTOPILOT_INVALID,
                0,
                0,
                mavlink.MAV_STATE_ACTIVE,
                3,
            )
        )

    def _next(self) -> int:
        sequence: int = self._mav.seq
        self._mav.seq = (sequence + 1) & 0xFF
        return sequence

    def _attitude_frame(self, now_us: int, eta: Sequence[float], nu: Sequence[float]) -> bytes:
        ms = now_us // 1000 & 0xFFFFFFFF
        return self._attitude.pack(self._next(), ms, 0.0, 0.0, _wrap(eta[2]), 0.0, 0.0, nu[2])

    def _local(self, now_us: int, eta: Sequence[float], nu: Sequence[float]) -> bytes:
        if self._frame is not None:
            eta = self._world.seen_from(self._frame, *eta)
        x, y, psi = eta
        u, v, _ = nu
        c, s = cos(psi), sin(psi)
        ms = now_us // 1000 & 0xFFFFFFFF
        out = b"" if self._attitude_rate else self._attitude_frame(now_us, eta, nu)
        return out + self._position.pack(
            self._next(), ms, x, y, 0.0, c * u - s * v, s * u + c * v, 0.0
        )

    def _global(self, now_us: int, eta: Sequence[float], nu: Sequence[float]) -> bytes:
        latitude, longitude, psi = self._world.geodetic(*eta)
        u, v, _ = nu
        c, s = cos(psi), sin(psi)
        out = b"" if self._attitude_rate else self._attitude_frame(now_us, eta, nu)
        return out + self._pack(
            mavlink.MAVLink_global_position_int_message(
                now_us // 1000 & 0xFFFFFFFF,
                latitude,
                longitude,
                self._origin[2],
                0,
                round(100.0 * (c * u - s * v)),
                round(100.0 * (s * u + c * v)),
                0,
                _UNKNOWN_HEADING,
            )
        )

    def _follow_target(self, now_us: int, eta: Sequence[float], nu: Sequence[float]) -> bytes:
        latitude, longitude, psi = self._world.geodetic(*eta)
        u, v, r = nu
        c, s = cos(psi), sin(psi)
        half = 0.5 * _wrap(psi)
        zeros = (0.0, 0.0, 0.0)
        return self._pack(
            mavlink.MAVLink_follow_target_message(
                now_us // 1000,
                _FOLLOW_CAPABILITIES,
                latitude,
                longitude,
                0.001 * self._origin[2],
                (c * u - s * v, s * u + c * v, 0.0),
                zeros,
                (cos(half), 0.0, 0.0, sin(half)),
                (0.0, 0.0, r),
                zeros,
                0,
            )
        )

    def _odometry(self, now_us: int, eta: Sequence[float], nu: Sequence[float]) -> bytes:
        x, y, psi = eta
        u, v, r = nu
        half = 0.5 * _wrap(psi)
        return self._pack(
            mavlink.MAVLink_odometry_message(
                now_us,
                mavlink.MAV_FRAME_LOCAL_NED,
                mavlink.MAV_FRAME_BODY_FRD,
                x,
                y,
                0.0,
                (cos(half), 0.0, 0.0, sin(half)),
                u,
                v,
                0.0,
                0.0,
                0.0,
                r,
                _UNKNOWN_COVARIANCE,
                _UNKNOWN_COVARIANCE,
                estimator_type=mavlink.MAV_ESTIMATOR_TYPE_GPS_INS,
            )
        )
