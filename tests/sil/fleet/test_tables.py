# SPDX-License-Identifier: MIT
"""Which epochs count for a new table, and which boats a stop's table reaches."""

from collections.abc import Sequence

import pytest
from pymavlink.dialects.v20 import ardupilotmega as mavlink

from sil.fleet.ends import End, Peer
from sil.fleet.orders import stop
from sil.fleet.tables import doubtful_epochs, epoch_at, newest_epoch, star
from sil.wire.fleet_table import Member, digest_of, table_message
from sil.wire.mavlink_messages import FLEET_TABLE
from tests.sil.fleet.waters import BOATS, Air, Waters, beacon_message, heard


@pytest.fixture
def waters() -> Waters:
    """Boats with table 1, in shape."""
    waters = Waters(boat_loss=0.0)
    assert waters.command(action="form", shape="vee", spacing_m=4.5, boats=BOATS)[0] == 0
    waters.wait((), 10.0)
    return waters


def form_after(waters: Waters, frame: bytes) -> tuple[int, str]:
    """`form`, which hears this frame first."""
    return waters.command(strange=[frame], action="form", shape="line", spacing_m=4.5, boats=BOATS)


def test_a_strangers_beacon_does_not_raise_the_epoch(waters: Waters) -> None:
    status, words = form_after(waters, beacon_message(77, 65534, 1))
    assert status == 0 and words.startswith("table 2 is in force with 4 of 4 boats")


def test_an_epoch_that_one_boat_alone_reports_is_doubtful_and_does_not_count() -> None:
    told = {1: 3, 2: 65534, 3: 3, 4: 2}
    assert doubtful_epochs(told) == {2: 65534}
    assert newest_epoch(told) == 3


@pytest.mark.parametrize(
    ("told", "newest"),
    [
        ({1: 60000, 2: 60000, 3: 59999}, 60000),
        ({1: 60000, 2: 60000, 3: 2}, 60000),  # one of them comes from another fleet
        ({1: 60000}, 60000),
        ({1: 12, 2: 3}, 12),  # it has missed some tables
        ({}, 0),
    ],
)
def test_a_high_epoch_that_boats_really_hold_counts(told: dict[int, int], newest: int) -> None:
    assert newest_epoch(told) == newest
    assert not doubtful_epochs(told)


def test_epochs_grow_with_the_day_and_wrap() -> None:
    noon_s = 1_800_000_000
    assert epoch_at(noon_s + 86400) == epoch_at(noon_s) + 144
    assert {epoch_at(0.0), epoch_at(600.0 * 65535)} == {1}
    assert epoch_at(600.0 * 65535 - 1.0) == 65535
    assert not doubtful_epochs({1: 3, 2: 30_000}, least=29_500)


def test_a_boat_with_an_older_sessions_table_does_not_bring_it_back() -> None:
    waters = Waters(boat_loss=0.0)
    waters.date_s = 1_800_000_000.0
    for shape in ("vee", "line", "vee"):
        assert waters.command(action="form", shape=shape, spacing_m=4.5, boats=BOATS)[0] == 0
    waters.fault(4, "radio_silent")
    for over in (False, True):
        for boat in BOATS[:3]:
            waters.fault(boat, "restart", over=over)
        waters.wait((), 8.0)
    waters.date_s += 86_400.0
    waters.command(action="form", shape="line", spacing_m=4.5, boats=BOATS[:3])
    waters.fault(4, "radio_silent", over=True)
    waters.wait((), 10.0)
    station = waters.station()
    station.run(3.0)
    told = {boat: station.last_beacon(boat) for boat in BOATS}
    assert {it.epoch for it in told.values() if it} == {epoch_at(waters.date_s)}


@pytest.mark.parametrize("formed", [False, True])
def test_of_two_simultaneous_operators_the_loser_is_informed(*, formed: bool) -> None:
    """Both ask for a table with the same epoch; the boats hear the other one's first."""
    waters = Waters(boat_loss=0.0)
    if formed:
        assert waters.command(action="form", shape="vee", spacing_m=4.5, boats=BOATS)[0] == 0
        waters.wait((), 30.0)
    places = [(0.0, 0.0), (-9.0, 0.0), (-18.0, 0.0), (-27.0, 0.0)]
    for digit in range(9):  # the digest must win, too
        other = star(BOATS, [(x, 0.1 * digit) for x, _ in places], [1.2] * 4)
        frame = table_message(1 + formed, other, assign=formed, in_s=3.0, sender=(254, 190))
        if formed or digest_of(frame) > 0x6000:
            break
    send = Air.send
    rivals: list[bytes] = []

    def second(air: Air, ours: bytes, peer: Peer) -> None:
        if FLEET_TABLE.to_bytes(3, "little") == ours[7:10] and not rivals:
            rivals.append(frame)
            for boat in BOATS:
                waters.batch.fleet.hear(waters.agent(boat), frame, waters.t_us)
            waters.wait((), 2.0)
        send(air, ours, peer)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Air, "send", second)
        status, words = waters.command(action="form", shape="line", spacing_m=4.5, boats=BOATS)
    assert status == 1
    assert words.startswith(f"table {1 + formed} of another station is in force, not this line")


def test_a_fleet_with_a_high_epoch_is_formed_and_stopped(waters: Waters) -> None:
    members = [Member(1, 0, (0.0, 0.0), 1.3)]
    members += [Member(boat, 1, (-4.0 * boat, 0.0), 1.3) for boat in BOATS[1:]]
    table = table_message(60000, members)
    for boat in BOATS:
        waters.batch.fleet.hear(waters.agent(boat), table, waters.t_us)
    waters.wait((), 5.0)
    status, words = waters.command(action="form", shape="vee", spacing_m=4.5, boats=BOATS)
    assert status == 0 and words.startswith("table 60001 is in force with 4 of 4 boats")
    waters.deaf = {4}
    waters.command(action="stop", boats=BOATS)
    assert waters.states == ["DISARMED"] * 3 + ["HOLD"]


def test_a_boat_that_alone_reports_a_high_epoch_is_named(waters: Waters) -> None:
    wait = waters.wait

    def flooded(ends: Sequence[End], for_s: float) -> Sequence[End]:
        told = wait(ends, for_s)
        heard(waters, beacon_message(2, 65534, 1))
        return told

    waters.wait = flooded
    status, words = waters.command(action="form", shape="line", spacing_m=4.5, boats=BOATS)
    assert status == 1 and "table 2 is in force with 3 of 4 boats" in words
    assert "boat 2 alone reports table 65534, the others at most 1: ignored" in words
    status, words = waters.command(action="stop")
    assert status == 0 and "boat 2 alone reports table 65534" in words


def test_a_stop_wins_over_a_shape_of_the_same_epoch(waters: Waters) -> None:
    """Boat 4 hears no order, only the other boats, which have the shape's table."""
    station = waters.station()
    station.run(3.0)
    send = station.send
    rivals: list[bytes] = []

    def with_rival(frame: bytes, system: int | None = None) -> None:
        if FLEET_TABLE.to_bytes(3, "little") == frame[7:10] and not rivals:
            rivals.append(rival(2))
            for boat in BOATS:
                waters.batch.fleet.hear(waters.agent(boat), rivals[0], waters.t_us)
        send(frame, system)

    station.send = with_rival
    waters.deaf = {4}
    stop(station, BOATS)
    assert rivals
    assert waters.states == ["DISARMED"] * 3 + ["HOLD"]


def rival(epoch: int) -> bytes:
    """A shape's table with this epoch."""
    members = [Member(1, 0, (0.0, 0.0), 1.3)]
    members += [Member(boat, 1, (-4.0 * boat, 0.0), 1.3) for boat in BOATS[1:]]
    return table_message(epoch, members, sender=(254, 190))


def test_a_boat_known_only_from_a_table_is_stopped_and_named(waters: Waters) -> None:
    members = [Member(1, 0, (0.0, 0.0), 1.3)]
    members += [Member(boat, 1, (-4.0 * boat, 0.0), 1.3) for boat in BOATS[1:]]
    waters.deaf = {4}
    table = table_message(1, members, sender=(2, 1))
    status, words = waters.command(strange=[table], action="stop")
    assert waters.states == ["DISARMED"] * 3 + ["HOLD"]
    assert (status, words.splitlines()) == (
        1,
        ["3 of 4 stopped and disarmed", "boat 4: not heard, known only from the fleet table"],
    )


def test_a_member_of_unknown_type_is_stopped_too(waters: Waters) -> None:
    """A table of boat 2 lists it; its HEARTBEAT could be another Rover's."""
    members = [Member(1, 0, (0.0, 0.0), 1.3), Member(9, 1, (-4.0, 0.0), 1.3)]
    table, beat = table_message(1, members, sender=(2, 1)), rovers_beat(9)
    status, words = waters.command(strange=[table, beat], action="stop")
    assert status == 1
    assert words.splitlines() == [
        "4 of 5 stopped and disarmed",
        "boat 9: no answer, and it is not heard",  # any more
    ]


def test_a_surface_boat_of_unknown_type_is_named_and_not_stopped(waters: Waters) -> None:
    beat = rovers_beat(9)
    status, words = waters.command(strange=[beat], action="stop")
    assert (status, words.splitlines()) == (
        1,
        [
            "4 of 4 stopped and disarmed",
            "boat 9 is heard, but does not say that it runs Flotilla: --boats 9 stops it",
        ],
    )
    status, words = waters.command(strange=[beat], action="stop", boats=(*BOATS, 9))
    assert words.splitlines()[0] == "4 of 5 stopped and disarmed"
    assert "Flotilla" not in words


def rovers_beat(system: int) -> bytes:
    """A HEARTBEAT of ArduPilot's, or of a boat with MAV_AUTOPILOT 1; armed, in HOLD."""
    rover = mavlink.MAVLink_heartbeat_message(11, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, 129, 4, 4, 3)
    frame: bytes = rover.pack(mavlink.MAVLink(None, system, 1))
    return frame


def test_a_strangers_table_adds_no_boat(waters: Waters) -> None:
    members = [Member(1, 0, (0.0, 0.0), 1.3), Member(9, 1, (-4.0, 0.0), 1.3)]
    station = waters.station()
    heard(waters, table_message(1, members, sender=(77, 1)))
    assert [answer.system for answer in stop(station, ())] == list(BOATS)
