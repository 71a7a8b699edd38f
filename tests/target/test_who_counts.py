# SPDX-License-Identifier: MIT
"""Which messages are the boat's own state, its leader's, or neither."""

from __future__ import annotations

import random

import flotilla
import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.course import TURN, Course
from tests.target.sea import Sea, at_sea
from tests.target.stations import (
    BOAT,
    GCS,
    LEADER,
    NAVIGATION,
    STRANGER,
    Station,
    attitude,
    heartbeat,
    local_position,
    odometry,
    origin,
)


def test_the_boats_own_echo_is_not_its_navigation_unit(sea: Sea) -> None:
    sea.own.on = False
    echo = Station(BOAT, 1)
    for _ in range(20):
        sea.say(
            odometry(Course(), sea.now_us),
            origin(),
            local_position(Course(), sea.now_us),
            sender=echo,
        )
        sea.say(attitude(Course(), sea.now_us), sender=echo)
        sea.run(0.05)
    assert not sea.condition("own_fresh")


def test_an_echo_of_all_its_messages_changes_nothing() -> None:
    quiet, echoing = Sea(), Sea()
    for sea in (quiet, echoing):
        sea.enter_formation()
        for _ in range(300):
            tick = sea.step()
            if sea is echoing:
                for _, data in tick.mavlink:
                    sea.boat.on_mavlink(data, sea.now_us)
    assert quiet.commands == echoing.commands and echoing.state == "FORMATION"


@pytest.mark.parametrize("system", [3, STRANGER, GCS, 0])
def test_a_foreign_system_is_neither_own_state_nor_leader(sea: Sea, system: int) -> None:
    sea.own.on = sea.leader.on = False
    foreign = Station(system, NAVIGATION)
    for _ in range(20):
        sea.say(
            odometry(Course(), sea.now_us),
            origin(sea.now_us),
            local_position(Course(), sea.now_us),
            attitude(Course(), sea.now_us),
            sender=foreign,
        )
        sea.run(0.05)
    assert not sea.condition("own_fresh") and not sea.condition("leader_fresh")
    assert sea.snapshot()["own_age_s"] is None and sea.snapshot()["leader_age_s"] is None


def test_the_leaders_component_that_was_heard_first_counts_until_it_is_silent() -> None:
    sea = Sea(own=Course())
    sea.leader.on = False
    nine, five, one = Station(LEADER, 9), Station(LEADER, 5), Station(LEADER, 1)
    for speakers, expected in (([nine], 0.9), ([one, five, nine], 0.9), ([five, one], 0.5)):
        for _ in range(40):
            for speaker in speakers:
                here = Course(0.1 * speaker.component)
                sea.say(origin(sea.now_us), odometry(here, sea.now_us), sender=speaker)
            sea.run(0.05)
        north = -sea.snapshot()["error"]["x_m"]  # the boat is at the origin and heads north
        assert north == pytest.approx(expected, abs=0.01)


@pytest.mark.parametrize("agent", ["own", "leader"])
@pytest.mark.parametrize("kind", ["ATTITUDE", "HEARTBEAT", "GPS_GLOBAL_ORIGIN"])
def test_a_component_with_an_incomplete_state_does_not_displace_another(
    sea: Sea, agent: str, kind: str
) -> None:
    whose = getattr(sea, agent)
    whose.station = Station(whose.station.system, NAVIGATION)
    sea.run(1.0)
    gimbal = Station(whose.station.system, 154)
    for _ in range(100):
        other = {
            "ATTITUDE": attitude(Course(psi=-1.0), sea.now_us),
            "HEARTBEAT": heartbeat(26),
            "GPS_GLOBAL_ORIGIN": origin(),
        }[kind]
        sea.say(other, sender=gimbal)
        sea.run(0.05)
        assert sea.condition(f"{agent}_fresh")


@pytest.mark.parametrize("system", [STRANGER, 3, 255, 0])
def test_a_foreign_system_moves_nothing(system: int) -> None:
    """A foreign system sends states, origins and clocks on the link: no byte on CAN changes."""
    rng = random.Random(system)
    alone, beset = Sea(leader=TURN), Sea(leader=TURN)
    strangers = [Station(system, component) for component in (1, NAVIGATION)]
    for sea in (alone, beset):
        sea.enter_formation()
    for _ in range(500):
        if beset.now_us % 50_000 == 0:
            where = Course(
                rng.uniform(-500, 500), rng.uniform(-500, 500), rng.uniform(-3, 3), 2.0, 1.0, 1.0
            )
            for stranger in strangers:
                beset.say(
                    heartbeat(),
                    origin(0, 0, 0, 0),
                    odometry(where, beset.now_us),
                    local_position(where, beset.now_us),
                    attitude(where, beset.now_us),
                    mavlink.MAVLink_timesync_message(beset.now_us * 999, beset.now_us * 1000),
                    sender=stranger,
                )
        assert alone.step().can == beset.step().can
    assert beset.state == "FORMATION"


def test_a_stranger_cannot_revive_a_silent_leader_or_navigation_unit() -> None:
    for who in ("own", "leader"):
        sea = at_sea()
        sea.silence(who)
        for _ in range(150):
            sea.say(odometry(Course(), sea.now_us), origin(), sender=Station(STRANGER, 1))
            sea.step()
        assert sea.state == ("HOLD" if who == "own" else "COAST")
        sea.run(5.0)
        assert sea.state == "HOLD" and sea.commands == (0, 0)


def test_a_leader_that_is_the_boat_itself_is_refused() -> None:
    with pytest.raises(ValueError, match="FORM_LEADER"):
        flotilla.Boat({"MAV_SYSID": BOAT, "FORM_LEADER": BOAT})
