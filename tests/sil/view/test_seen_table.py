# SPDX-License-Identifier: MIT
"""The sentence about the fleet's table on the live page."""

import struct

from sil.view.seen_table import SeenTable
from sil.wire import mavlink_messages as messages
from sil.wire.fleet_table import Member, table_message
from sil.wire.mavlink_ear import Ear
from tests.dialect import dialect

FIT, LEADS = 1, 2
MEMBERS = [Member(k, k - 1, (-3.0 * k, 0.0), 1.3) for k in (1, 2, 3)]


def beacon(system: int, epoch: int, flags: int) -> bytes:
    mav = dialect().MAVLink(None, srcSystem=system, srcComponent=1)
    message = dialect().MAVLink_fleet_beacon_message(epoch, 7, flags, 0, 0, 0, 1)
    return bytes(message.pack(mav))


def heard(table: SeenTable, now_s: float, *frames: bytes) -> str:
    ear = Ear(stream=False)
    for frame in frames:
        for message in ear.hear(frame):
            table.hear(message, now_s)
    return table.line(now_s)


def test_without_a_table_the_line_is_empty() -> None:
    assert SeenTable().line(0.0) == ""
    assert heard(SeenTable(), 0.0, beacon(1, 0, FIT)) == ""


def test_the_line_names_the_leader_and_boats_with_an_older_table() -> None:
    table = SeenTable()
    now = heard(table, 1.0, *(beacon(k, 4, FIT | LEADS * (k == 2)) for k in (1, 2, 3)))
    assert now == "table 4, boat 2 leads"
    assert (
        heard(table, 2.0, beacon(2, 5, FIT))
        == "table 5, no boat leads, boats 1 and 3 have an older one"
    )
    assert (
        heard(table, 3.0, beacon(1, 5, FIT | LEADS))
        == "table 5, boat 1 leads, boat 3 has an older one"
    )
    assert table.line(4.5) == "table 5, boat 1 leads"  # boat 3 is silent
    assert table.line(9.0) == ""


def test_a_pending_table_is_reported_with_its_time() -> None:
    table, beacons = SeenTable(), [beacon(k, 6, FIT | LEADS * (k == 1)) for k in (1, 2)]
    message = table_message(6, MEMBERS, in_s=4.0)
    wanted = "table 6 comes into force in 4 s, boat 1 leads"
    assert heard(table, 10.0, message, *beacons) == wanted
    assert table.line(12.0) == "table 6 comes into force in 2 s, boat 1 leads"
    assert heard(table, 14.5, *beacons) == "table 6, boat 1 leads"
    # a boat that was away is sent the table that is in force
    payload = bytearray(message[10:-2])
    struct.pack_into("<H", payload, 0, 900)
    payload[8] |= 8
    fields = messages.LAYOUTS[messages.FLEET_TABLE].unpack(bytes(payload).ljust(202, b"\0"))
    (again,) = Ear(stream=False).hear(message)
    table.hear(again._replace(fields=fields), 14.6)
    assert table.line(14.6) == "table 6, boat 1 leads"
