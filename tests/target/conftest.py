# SPDX-License-Identifier: MIT
"""A simulated sea for each test, and two long runs shared by many tests."""

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.bus import NODE, TOOL, node_info_request
from tests.target.course import Course
from tests.target.sea import Sea
from tests.target.stations import FORMATION, odometry


@pytest.fixture
def sea() -> Sea:
    """A boat, its navigation unit, its leader and its two ESCs, without faults."""
    return Sea()


@pytest.fixture(scope="session")
def voyage() -> Sea:
    """Ten minutes that contain every message of a boat, on two links."""
    # The true motion ignores thrust: an observer would learn forces that do not exist, and a boat
    # out of its slot would report that it does not answer to its propellers.
    sea = Sea(
        {"CTL_RATE": 50, "LAW_OBS_BW": 0.0, "LAW_CUR_BW": 0.0},
        links=2,
        own=Course(3.0, -4.0, 2.5, 0.6, 0.1, 0.05),
        leader=Course(3.0, -4.0, 2.5, 0.6, 0.1, 0.05),
    )
    sea.leader.answers_timesync = True
    sea.run(1.0)
    sea.own.on = False
    sea.run(1.0)
    sea.arm()  # refused
    sea.own.on = True
    sea.run(1.0)
    for k in range(20):
        sea.arm()
        sea.run(1.0 + k % 3)
        sea.mode(FORMATION)
        sea.run(5.0)
        silent = (sea.leader, sea.own, sea.escs[k % 2])[k % 3]
        silent.on = False  # COAST, HOLD, FAULT
        sea.run(2.0)
        silent.on = True
        sea.order(511, 30.0, 1e5)
        sea.run(1.0)
        sea.say(mavlink.MAVLink_timesync_message(0, 10**15 + k), link=1)
        sea.say(odometry(Course(), sea.now_us, frame_id=20), sender=sea.own.station)
        sea.disarm()
        sea.run(20.0)
    return sea


@pytest.fixture(scope="session")
def outing() -> Sea:
    """Two minutes with arming, sailing, a fault and node info requests."""
    sea = Sea(leader=Course(15.0, -9.0, 0.5, 0.4, 0.0, 0.1))
    sea.settle()
    for k in range(6):
        sea.arm()
        sea.run(1.0)
        sea.mode(FORMATION)
        sea.run(10.0)
        sea.escs[k % 2].on = k % 3 == 0
        for n in range(3):
            sea.on_can(node_info_request(TOOL, NODE, (7 * k + n) % 32))
            sea.step()
        sea.run(2.0)
        sea.escs[k % 2].on = True
        sea.disarm()
        sea.run(5.0)
    return sea
