# SPDX-License-Identifier: MIT
"""Systems that a station takes for boats, and beacons that count."""

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.fleet.orders import carry_out, long, stop
from sil.fleet.station import Station
from sil.wire.heartbeat import HOLD
from sil.wire.operator import mode_request
from tests.sil.fleet.waters import BOATS, Waters, beacon_message, heard


@pytest.fixture
def waters() -> Waters:
    return Waters()


def beat_of(system: int, component: int, kind: int, autopilot: int, mode: int) -> bytes:
    beat = mavlink.MAVLink_heartbeat_message(kind, autopilot, 0, mode, 4, 3)
    frame: bytes = beat.pack(mavlink.MAVLink(None, system, component))
    return frame


def heard_by(waters: Waters, *frames: bytes) -> Station:
    """A station that has heard the boats, and these frames."""
    station = waters.station()
    for frame in frames:
        heard(waters, frame)
    station.run(2.0)
    return station


def test_a_system_that_sends_only_a_beacon_is_no_boat(waters: Waters) -> None:
    station = heard_by(waters, beacon_message(77, 1, 5))
    assert station.boats() == list(BOATS)
    assert station.beacon(77) is None
    waters.wait((), 1.0)
    assert waters.command(action="status")[0] == 0


@pytest.mark.parametrize(
    ("component", "kind", "autopilot", "mode"),
    [
        (1, mavlink.MAV_TYPE_GCS, mavlink.MAV_AUTOPILOT_INVALID, 0),
        (1, mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_AUTOPILOT_GENERIC, 3),  # no Flotilla's mode
        (154, mavlink.MAV_TYPE_GIMBAL, mavlink.MAV_AUTOPILOT_INVALID, 0),
        (1, mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_AUTOPILOT_PX4, 0),
    ],
)
def test_a_system_with_a_heartbeat_of_another_type_is_no_boat(
    waters: Waters, component: int, kind: int, autopilot: int, mode: int
) -> None:
    beat = beat_of(77, component, kind, autopilot, mode)
    station = heard_by(waters, beat, beacon_message(77, 1, 5))
    assert station.boats() == list(BOATS)


def test_a_beacon_counts_with_the_heartbeat_of_its_component(waters: Waters) -> None:
    boat = mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_AUTOPILOT_GENERIC, 4
    station = heard_by(waters, beacon_message(77, 3, 5), beat_of(77, 1, *boat))
    beacon = station.beacon(77)
    assert station.boats() == [*BOATS, 77]
    assert beacon is not None and beacon.epoch == 3
    station = heard_by(waters, beacon_message(78, 3, 5, component=191), beat_of(78, 1, *boat))
    assert station.beacon(78) is None


def test_orders_to_a_companion_name_its_component_and_a_stop_names_all(
    waters: Waters, monkeypatch: pytest.MonkeyPatch
) -> None:
    companion = mavlink.MAV_COMP_ID_ONBOARD_COMPUTER
    sender = mavlink.MAVLink(None, 77, companion)
    invalid, boat = mavlink.MAV_AUTOPILOT_INVALID, mavlink.MAV_TYPE_SURFACE_BOAT
    station = heard_by(
        waters,
        beat_of(77, 1, boat, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 4),
        mavlink.MAVLink_named_value_float_message(0, b"COND", 0.0).pack(sender),
        beat_of(77, companion, mavlink.MAV_TYPE_ONBOARD_CONTROLLER, invalid, 4),
        beat_of(77, 1, boat, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 4),
    )
    assert station.boats() == [*BOATS, 77]
    said: list[mavlink.MAVLink_message] = []
    monkeypatch.setattr(station, "say", lambda message, system=None: said.append(message))

    def components(system: int) -> set[int]:
        orders = [m for m in said if m.get_type() == "COMMAND_LONG" and m.target_system == system]
        return {order.target_component for order in orders}

    carry_out(station, long(mode_request(HOLD)), (*BOATS, 77))
    assert (components(1), components(77)) == ({1}, {companion})
    said.clear()
    stop(station, (99,))
    assert (components(1), components(77), components(99)) == ({0}, {0}, {0})
