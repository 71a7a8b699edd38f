# SPDX-License-Identifier: MIT
"""Senders for a view: real boats in lockstep, and stations by pymavlink's encoder."""

from collections.abc import Callable, Sequence
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from sil.lockstep.world import sail
from sil.plant.hull import Array
from sil.scenario import scenario
from sil.view.seen_fleet import Fleet
from sil.wire.mavlink_ear import Ear
from tests.target.stations import Station

Told = list[dict[str, Any]]
# Called at each tick with its number, each agent's bytes on the radio, and the true poses.
Look = Callable[[int, list[bytes], Array], None]

BEAT = mavlink.MAVLink_heartbeat_message(
    mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_AUTOPILOT_GENERIC, 1 | 128 | 8, 6, 4, 3
)
VIRTUAL = mavlink.MAVLink_heartbeat_message(
    mavlink.MAV_TYPE_GENERIC, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 4, 3
)


def sail_and_look(look: Look, *overrides: str, name: str = "diamond") -> None:
    """Sail a scenario; calls `look` at each tick from the release on."""
    chosen = scenario.load(name, overrides)
    agents = range(len(chosen.boat) + 1)

    def watch(batch: Any, _: Sequence[int], k: int, __: int) -> None:
        look(k, [bytes(batch.fleet.sent(agent)) for agent in agents], batch.bodies.eta)

    (run,) = sail([chosen], {}, watch=watch)
    assert not isinstance(run, Exception), run


class Listening:
    """A fleet's view that gets given messages at given times."""

    def __init__(self) -> None:
        self.ear = Ear(stream=False)
        self.fleet = Fleet(1.0)

    def hear(self, data: bytes, now_s: float) -> None:
        self.fleet.hear(self.ear.hear(data), now_s)

    def by_id(self, now_s: float) -> dict[int, dict[str, Any]]:
        return {vessel["id"]: vessel for vessel in self.fleet.vessels(now_s)}


def value(name: str, number: float) -> Any:
    return mavlink.MAVLink_named_value_float_message(0, name.encode(), number)


def local(x: float, y: float, vx: float = 0.0, vy: float = 0.0) -> Any:
    return mavlink.MAVLink_local_position_ned_message(0, x, y, 0.0, vx, vy, 0.0)


def attitude(psi: float, boot_ms: int = 0) -> Any:
    return mavlink.MAVLink_attitude_message(boot_ms, 0.0, 0.0, psi, 0.0, 0.0, 0.0)


def origin(latitude: int, longitude: int, altitude: int = 0) -> Any:
    return mavlink.MAVLink_gps_global_origin_message(latitude, longitude, altitude, 0)


def slot(x: float, y: float) -> Any:
    return mavlink.MAVLink_position_target_local_ned_message(
        0, 1, 0, x, y, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    )


def said(system: int, *messages: Any, component: int = 1) -> bytes:
    return Station(system, component).pack(*messages)
