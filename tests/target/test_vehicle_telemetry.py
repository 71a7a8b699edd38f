# SPDX-License-Identifier: MIT
"""Vehicle telemetry as an operator sees it: health, clock, position, slot."""

from __future__ import annotations

import math
from collections.abc import Callable

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import Course, wrap
from tests.target.geodesy import Globe
from tests.target.sea import PAPER, Sea, acks, at_sea, named
from tests.target.stations import (
    BOAT,
    FORMATION,
    LEADER,
    NAVIGATION,
    ORIGIN,
    REQUEST_MESSAGE,
    TEMPORARILY_REJECTED,
    Station,
    origin,
)
from tests.target.test_other_nodes import FOREIGN
from tests.turns import some

GYRO, ACCEL, MAG, GPS, XY_CONTROL, MOTORS, AHRS = 1, 2, 4, 32, 0x4000, 0x8000, 0x200000
GEOFENCE, BATTERY, PREARM, PROPULSION = 0x100000, 0x2000000, 0x10000000, 0x40000000
NAVIGATION_BITS = GYRO | ACCEL | MAG | GPS | XY_CONTROL | AHRS
MOTOR_BITS = MOTORS | PROPULSION
SAIL = Course(30.0, -40.0, 2.5, 0.6, 0.1, 0.05)
GLOBE = Globe(*ORIGIN)


def health(sea: Sea) -> int:
    """The present health bits: after one more tick, as a boat reports the last tick's."""
    sea.step()
    (told,) = sea.ask(1)
    return int(told.onboard_control_sensors_health)


def test_the_health_has_a_bit_for_all_that_clients_look_at(sea: Sea) -> None:
    sea.settle()
    (told,) = sea.ask(1)
    present = told.onboard_control_sensors_present
    assert present == told.onboard_control_sensors_enabled
    everything = NAVIGATION_BITS | MOTOR_BITS | PREARM
    assert present & everything == everything
    assert told.onboard_control_sensors_health == present | GEOFENCE


def no_own_state(sea: Sea) -> None:
    sea.own.on = not sea.own.on


def escs_silent(sea: Sea) -> None:
    for esc in sea.escs:
        esc.on = not esc.on


def one_esc_ill(sea: Sea) -> None:
    sea.escs[1].health = 2 - sea.escs[1].health


def bus_down(sea: Sea) -> None:
    sea.boat.on_host(bus_up=not sea.condition("bus_up"))


def parameters_unsaved(sea: Sea) -> None:
    sea.boat.on_host(parameters_saved=not sea.condition("parameters_saved"))


def another_controller(sea: Sea) -> None:
    if sea.condition("sole_controller"):
        sea.on_can(FOREIGN["RawCommand"])
        sea.step()
    else:
        sea.run(2.1)


@pytest.mark.parametrize(
    ("toggle", "others"),
    [
        (no_own_state, NAVIGATION_BITS),
        (escs_silent, MOTOR_BITS),
        (one_esc_ill, MOTOR_BITS),
        (bus_down, MOTOR_BITS),
        (parameters_unsaved, 0),
        (another_controller, None),
    ],
)
def test_the_prearm_bit_follows_each_check_both_ways(
    sea: Sea, toggle: Callable[[Sea], None], others: int | None
) -> None:
    everything = NAVIGATION_BITS | MOTOR_BITS | PREARM | GEOFENCE | BATTERY
    wait_s = 0.0 if toggle is another_controller else 1.6
    sea.run(1.6)
    for _ in range(2):
        assert health(sea) == everything
        toggle(sea)
        sea.run(wait_s)
        now = health(sea)
        assert not now & PREARM
        if others is not None:
            assert now == everything & ~PREARM & ~others
        only_manual = toggle is no_own_state
        assert acks(sea.arm()) == [(400, 0 if only_manual else 1)]
        assert sea.state == ("HOLD" if only_manual else "DISARMED")
        sea.disarm()
        toggle(sea)
        sea.run(wait_s)
    assert health(sea) == everything
    assert acks(sea.arm()) == [(400, 0)]


@pytest.mark.parametrize("altitude_mm", [0, 488_000], ids=["sea level", "lake"])
def test_the_place_on_the_globe_is_where_the_boat_is(altitude_mm: int) -> None:
    sea = Sea(own=Course(300.0, -400.0, 2.5, 0.6, 0.1, 0.05))
    sea.own.origin_on = False
    sea.say(origin(altitude=altitude_mm), sender=sea.own.station)
    sea.run(5.0)
    globe = Globe(ORIGIN[0], ORIGIN[1], altitude_mm)
    told = named(sea.run(10.0), "GLOBAL_POSITION_INT")
    assert len(told) == 20
    for m in told:
        truth = sea.own.truth(m.time_boot_ms * 1000)
        # Above sea level a degree is longer than in the boat's model, by 0.04 m on this lake.
        slack = 2 if altitude_mm == 0 else 5
        assert (m.lat, m.lon) == pytest.approx(globe.degrees(truth.north, truth.east), abs=slack)
        assert (m.alt, m.relative_alt) == (altitude_mm, 0)
        velocity = [100 * v for v in truth.velocity_n]
        assert (m.vx, m.vy, m.vz) == pytest.approx((*velocity, 0.0), abs=1.5)
        assert 0 <= m.hdg < 36000
        assert abs(wrap(math.radians(m.hdg / 100) - truth.psi)) < 0.01


@pytest.mark.parametrize("psi", [-3.1, -1.0, -1e-5, 0.0, 1e-5, 3.1])
def test_the_heading_is_never_360_degrees(psi: float) -> None:
    sea = Sea(own=Course(1.0, 2.0, psi))
    for m in some(named(sea.run(3.0), "GLOBAL_POSITION_INT")):
        assert 0 <= m.hdg < 36000
        assert abs(wrap(math.radians(m.hdg / 100) - psi)) < 0.001


def test_home_is_where_the_boat_was_armed() -> None:
    sea = Sea(own=Course(3.0, -4.0, 2.5, 0.6, 0.0, 0.05))
    sea.run(1.0)
    first = sea.own.truth(named(sea.ticks, "HOME_POSITION")[0].time_usec)
    (home,) = sea.ask(242)
    assert (home.latitude, home.longitude) == pytest.approx(
        GLOBE.degrees(first.north, first.east), abs=3
    )
    sea.run(20.0)
    sea.arm()
    there = sea.own.truth(sea.ticks[-1].now_us)
    sea.run(20.0)
    (home,) = sea.ask(242)
    assert (home.latitude, home.longitude) == pytest.approx(
        GLOBE.degrees(there.north, there.east), abs=3
    )
    sea.disarm()
    sea.run(5.0)
    (again,) = sea.ask(242)
    assert (again.latitude, again.longitude) == (home.latitude, home.longitude)


def test_home_has_the_altitude_of_the_boats_origin(sea: Sea) -> None:
    """Clients subtract one from the other; a boat's home has the height of its lake."""
    sea.run(1.0)
    (home,), (place,) = sea.ask(242), sea.ask(33)
    assert home.altitude == place.alt - place.relative_alt == ORIGIN[2]


def test_a_boat_that_never_knew_its_place_has_no_home(sea: Sea) -> None:
    sea.own.origin_on = False
    sea.run(5.0)
    assert not named(sea.ticks, "HOME_POSITION")
    assert acks(sea.order(512, 242.0)) == [(512, 1)]


def test_system_time_is_the_hosts_clock(sea: Sea) -> None:
    epoch_us = 1_790_000_000_000_000
    for _ in range(300):
        sea.boat.on_host(unix_us=epoch_us + sea.now_us)
        tick = sea.step()
        for m in tick.named("SYSTEM_TIME"):
            assert m.time_unix_usec == epoch_us + tick.now_us
            assert m.time_boot_ms == tick.now_us // 1000
    assert len(named(sea.ticks, "SYSTEM_TIME")) == 3


def test_system_time_is_zero_while_the_host_does_not_know_the_time(sea: Sea) -> None:
    sea.run(3.0)
    assert {m.time_unix_usec for m in named(sea.ticks, "SYSTEM_TIME")} == {0}


SLOT = {"FORM_OFS_N": -6.0, "FORM_OFS_E": 4.5}


@pytest.mark.parametrize("where", [ORIGIN, (ORIGIN[0] + 60_000, ORIGIN[1] - 40_000, ORIGIN[2])])
@pytest.mark.parametrize("sailing", [False, True])
def test_the_target_is_the_slot_beside_the_leader(where: tuple[int, ...], sailing: bool) -> None:
    leader = Course(15.0, -9.0, 3.1, 0.5, 0.0, 0.1)
    # In the published law the slot has its leader's heading; the hull's own sway turns it a little.
    sea = Sea(SLOT | {"SR_SLOW": 10, "FORM_DIST_MAX": 0} | PAPER, own=SAIL, leader=leader)
    sea.leader.origin_on = False
    sea.say(origin(0, *where), sender=sea.leader.station)
    sea.run(5.0)
    if sailing:
        sea.arm()
        sea.mode(FORMATION)
        assert sea.state == "FORMATION"
    shift = GLOBE.local(Globe(*where))
    told = named(sea.run(5.0), "POSITION_TARGET_LOCAL_NED")
    assert len(told) == 50
    for m in told:
        truth = sea.leader.truth(m.time_boot_ms * 1000)
        expected = truth.north + shift[0] - 6.0, truth.east + shift[1] + 4.5, 0.0
        assert (m.x, m.y, m.z) == pytest.approx(expected, abs=0.03)
        assert abs(wrap(m.yaw - truth.psi)) < 0.01
        assert m.coordinate_frame == 1
        assert m.type_mask == 0x9F8  # without velocity, acceleration and yaw rate


@pytest.mark.parametrize(
    "leader", [Course(15.0, -9.0, 3.1, 0.5, 0.0, 0.1), Course(-40.0, -90.0, -3.1, 0.5, 0.0, -0.1)]
)
def test_the_way_to_the_slot_has_a_bearing_and_a_length(leader: Course) -> None:
    sea = Sea(SLOT | {"SR_SLOW": 10}, own=SAIL, leader=leader)
    sea.run(5.0)
    told = 0
    for tick in sea.run(5.0):
        for m in tick.named("NAV_CONTROLLER_OUTPUT"):
            told += 1
            own, ahead = sea.own.truth(tick.now_us), sea.leader.truth(tick.now_us)
            north, east = ahead.north - 6.0 - own.north, ahead.east + 4.5 - own.east
            assert m.wp_dist == pytest.approx(math.hypot(north, east), abs=0.55)
            assert -180 <= m.target_bearing <= 180 and -180 <= m.nav_bearing <= 180
            bearing = math.atan2(east, north)
            assert abs(wrap(math.radians(m.target_bearing) - bearing)) < math.radians(1.0)
            assert abs(wrap(math.radians(m.nav_bearing) - ahead.psi)) < math.radians(1.5)
            abeam = math.sin(own.psi) * north - math.cos(own.psi) * east
            assert m.xtrack_error == pytest.approx(abeam, abs=0.05)
    assert told > 40


@pytest.mark.parametrize("who", ["own", "leader"])
def test_without_a_leader_or_an_own_state_there_is_no_slot(sea: Sea, who: str) -> None:
    sea.run(1.0)
    sea.silence(who)
    sea.run(1.1)
    ticks = sea.run(3.0)
    for message_id, name in ((62, "NAV_CONTROLLER_OUTPUT"), (85, "POSITION_TARGET_LOCAL_NED")):
        assert not named(ticks, name)
        assert acks(sea.order(512, float(message_id))) == [(512, 1)]


def test_followers_get_the_boat_as_follow_target() -> None:
    sea = Sea(own=Course(30.0, -40.0, 2.5, 1.0, 0.1, 0.2))
    sea.run(5.0)
    assert acks(sea.order(511, 144.0, 100_000.0)) == [(511, 0)]
    told = named(sea.run(5.0), "FOLLOW_TARGET")
    assert len(told) == 50
    for m in told:
        truth = sea.own.truth(m.timestamp * 1000)
        assert m.est_capabilities == 15  # position, velocity, acceleration, attitude and rates
        assert (m.lat, m.lon) == pytest.approx(GLOBE.degrees(truth.north, truth.east), abs=3)
        north, east = truth.velocity_n
        assert list(m.vel) == pytest.approx([north, east, 0.0], abs=0.02)
        # Turning at r causes the acceleration r × v.
        assert list(m.acc) == pytest.approx([-0.2 * east, 0.2 * north, 0.0], abs=0.05)
        heading = 2 * math.atan2(m.attitude_q[3], m.attitude_q[0])
        assert abs(wrap(heading - truth.psi)) < 0.01
        assert math.hypot(*m.attitude_q) == pytest.approx(1.0, abs=1e-5)
        assert list(m.rates) == pytest.approx([0.0, 0.0, 0.2], abs=0.01)


def test_followers_see_the_boat_at_the_height_of_its_lake(sea: Sea) -> None:
    sea.run(1.0)
    (target,), (place,) = sea.ask(144), sea.ask(33)
    assert target.alt * 1000 == pytest.approx(place.alt, abs=1) == ORIGIN[2]


def test_the_heads_up_display_has_speed_and_heading() -> None:
    sea = Sea(own=SAIL)
    told = named(sea.run(5.0), "VFR_HUD")
    assert 5 <= len(told) <= 6
    assert told[-1].groundspeed == pytest.approx(math.hypot(SAIL.u, SAIL.v), abs=0.01)
    truth = math.degrees(sea.own.truth(sea.now_us).psi) % 360
    assert told[-1].heading == pytest.approx(truth, abs=3.5)  # turns by 2.9 degrees a second
    assert told[-1].alt == pytest.approx(1e-3 * ORIGIN[2])
    assert told[-1].climb == told[-1].airspeed == told[-1].throttle == 0


def test_the_throttle_is_the_share_of_both_propellers_thrust() -> None:
    sea = at_sea({"THR_SLEW": 0.0})
    before = sea.commands
    (told,) = sea.ask(mavlink.MAVLINK_MSG_ID_VFR_HUD)
    shares = [50 * sum(map(abs, each)) / 8191 for each in (before, sea.commands)]
    assert told.throttle == pytest.approx(shares[0], abs=2 + abs(shares[0] - shares[1]))
    assert told.throttle > 5


def test_the_units_fix_is_forwarded_while_it_is_received() -> None:
    sea = Sea()
    sea.own.tells_fix = False
    sea.settle()
    asked = (REQUEST_MESSAGE, float(mavlink.MAVLINK_MSG_ID_GPS_RAW_INT))
    assert not named(sea.run(3.0), "GPS_RAW_INT")
    assert acks(sea.order(int(asked[0]), asked[1])) == [(REQUEST_MESSAGE, TEMPORARILY_REJECTED)]
    place = (ORIGIN[0] + 3, ORIGIN[1] - 4, 490_500)
    fix = mavlink.MAVLink_gps_raw_int_message(
        7, 5, *place, 121, 65535, 37, 9000, 17, 1, 20, 30, 4, 5, 600
    )
    ticks = []
    for _ in range(15):
        sea.say(fix, sender=Station(BOAT, NAVIGATION))
        ticks += sea.run(0.2)
    told = named(ticks, "GPS_RAW_INT")
    assert 2 <= len(told) <= 4
    assert {m.to_json() for m in told} == {fix.to_json()}
    sea.run(2.0)
    for stranger in (Station(BOAT, NAVIGATION + 1), Station(LEADER, 1)):
        sea.say(fix, sender=stranger)
    assert acks(sea.order(int(asked[0]), asked[1])) == [(REQUEST_MESSAGE, TEMPORARILY_REJECTED)]
