# SPDX-License-Identifier: MIT
"""The fleet's messages against pymavlink with our dialect."""

import flotilla
import pytest

from sil.wire.fleet_table import Beacon, Member, beacons, digest_of, table_message
from tests.dialect import dialect

MEMBERS = [
    Member(1, 0, (0.0, 0.0), 1.2),
    Member(7, 1, (-4.0, 3.25), 1.2),
    Member(200, 0, (-8.5, -327.68), 5.0, only_leads=True),
    Member(9, 7, (0.01, 12.0), 0.9, can_lead=False),
]


def test_pymavlink_reads_the_table() -> None:
    frame = table_message(300, MEMBERS, turns=True, in_s=2.5, move_s=12.34)
    mav = dialect().MAVLink(None)
    (message,) = mav.parse_buffer(frame)
    assert (message.epoch, message.in_ms, message.flags) == (300, 2500, 1)
    assert message.move_ds == 123
    assert (message.get_srcSystem(), message.get_srcComponent()) == (255, 190)
    rows = [message.members[8 * i : 8 * i + 8] for i in range(5)]
    assert rows[0] == [1, 0, 1, 12, 0, 0, 0, 0]
    assert rows[1] == [7, 1, 1, 12, *(-400).to_bytes(2, "little", signed=True), 69, 1]
    assert rows[2][:4] == [200, 0, 2, 50] and rows[3][:4] == [9, 7, 0, 9]
    assert bytes(rows[2][6:]) == b"\x00\x80" and rows[4] == [0] * 8


@pytest.mark.parametrize(("stop", "assign", "flags"), [(True, False, 2), (False, True, 4)])
def test_a_stop_and_a_request_to_give_the_places_are_flags(
    *, stop: bool, assign: bool, flags: int
) -> None:
    frame = table_message(2, MEMBERS, stop=stop, assign=assign)
    (message,) = dialect().MAVLink(None).parse_buffer(frame)
    assert message.flags == flags


def test_more_members_than_a_message_holds_are_refused() -> None:
    many = [Member(i + 1, 0, (3.0 * i, 0.0), 1.0) for i in range(25)]
    assert len(table_message(1, many[:24])) <= 12 + 202
    with pytest.raises(ValueError, match="25 members"):
        table_message(1, many)


def test_beacons_are_read() -> None:
    ours = dialect()
    mav = ours.MAVLink(None, srcSystem=3, srcComponent=1)
    message = ours.MAVLink_fleet_beacon_message(
        epoch=5, digest=77, flags=3, leader=1, plan_id=123456, plan_item=4, sequence=9
    )
    other = ours.MAVLink_heartbeat_message(11, 0, 0, 0, 0, 3).pack(mav)
    found = list(beacons(other + message.pack(mav) + other))
    assert found == [(3, Beacon(5, True, True, 1, 4, 77))]
    assert not list(beacons(other))


def test_the_digest_equals_the_firmwares() -> None:
    """The epoch and the time until a table is in force are no part of it; flags and members are."""
    boat = flotilla.Boat({"MAV_SYSID": 7}, links=1)
    for epoch, turns in ((1, False), (2, True), (9, True)):
        frame = table_message(epoch, MEMBERS, turns=turns, in_s=1.0)
        boat.on_mavlink(frame, epoch * 1_000_000, link=0)
        said = b"".join(
            data
            for tick in range(50)
            for _, data in boat.tick(epoch * 1_000_000 + 10_000 * tick).mavlink
        )
        told = [beacon for _, beacon in beacons(said) if beacon.epoch == epoch]
        assert told and {beacon.digest for beacon in told} == {digest_of(frame)}
        assert digest_of(frame) == digest_of(table_message(epoch + 1, MEMBERS, turns=turns))
        assert digest_of(frame) != digest_of(table_message(epoch, MEMBERS, turns=not turns))
