# SPDX-License-Identifier: MIT
"""A fleet's table from a ground station, and the beacons of its members.

Source: firmware/link/mavlink/flotilla.xml; on the wire, fields are sorted by size, the widest
first.
"""

import struct
from collections.abc import Iterator, Sequence
from itertools import takewhile
from operator import itemgetter
from typing import NamedTuple

from pymavlink.generator.mavcrc import x25crc

from sil.wire.mavlink_frames import HEADER, MAGIC_2, frames
from sil.wire.mavlink_messages import FLEET_BEACON, FLEET_TABLE, LAYOUTS, SEEDS

_TURNS, _STOP, _ASSIGN = 1, 2, 4
_CAN_LEAD, _ONLY_LEADS = 1, 2
_TABLE, _MEMBER = struct.Struct("<HHHHBB"), struct.Struct("<BBBBhh")
_BEACON = LAYOUTS[FLEET_BEACON]
MOST_MEMBERS = 24
_TABLE_BYTES = _TABLE.size + _MEMBER.size * MOST_MEMBERS


class Member(NamedTuple):
    """A member: its system id and its leader's (0: it leads), and its place in the shape (m).

    The place is north and east, or ahead and to starboard if the shape turns.
    """

    system: int
    leader: int
    place_m: tuple[float, float]
    length_m: float
    can_lead: bool = True
    only_leads: bool = False


class HeardTable(NamedTuple):
    """The places of a table, m, by system id: north and east; ahead and to starboard if `turns`."""

    epoch: int
    turns: bool
    places: dict[int, tuple[float, float]]
    digest: int = 0


class Beacon(NamedTuple):
    """A member's report: newest table, fit to follow or to take over, leads."""

    epoch: int
    fit: bool
    leads: bool
    follows: int
    plan_item: int
    digest: int = 0


def table_message(
    epoch: int,
    members: Sequence[Member],
    *,
    turns: bool = False,
    stop: bool = False,
    assign: bool = False,
    in_s: float = 0.0,
    move_s: float = 0.0,
    sender: tuple[int, int] = (255, 190),
) -> bytes:
    """A FLEET_TABLE frame: the members by rank, in force after `in_s`. ValueError beyond 24.

    `move_s`: the time that the boats take from then on to their new places. `assign`: a boat that
    receives the table assigns the places to the members and chooses `move_s`.
    """
    if len(members) > MOST_MEMBERS:
        raise ValueError(f"{len(members)} members: a table has at most {MOST_MEMBERS}")
    flags = _TURNS * turns | _STOP * stop | _ASSIGN * assign
    head = _TABLE.pack(round(1000 * in_s), epoch, round(10 * move_s), 0, flags, 0)
    payload = head + b"".join(map(_packed, members))
    return _frame(FLEET_TABLE, payload.rstrip(b"\0"), sender)


def heard_table(frame: bytes) -> HeardTable:
    """The places in a FLEET_TABLE frame, whose checksum was compared before."""
    payload = _payload(frame)
    _, epoch, _, _, flags, _ = _TABLE.unpack_from(payload)
    members = takewhile(itemgetter(0), _MEMBER.iter_unpack(payload[_TABLE.size :]))
    places = {system: (0.01 * x_cm, 0.01 * y_cm) for system, _, _, _, x_cm, y_cm in members}
    return HeardTable(epoch, bool(flags & _TURNS), places, digest_of(frame))


def beacon_message(epoch: int, digest: int, sequence: int, sender: tuple[int, int]) -> bytes:
    """A FLEET_BEACON frame of a non-member with that table; boats answer with a newer table."""
    payload = _BEACON.pack(0, epoch, digest, 0, 0, 0, sequence)
    return _frame(FLEET_BEACON, payload.rstrip(b"\0"), sender)


def beacons(data: bytes) -> Iterator[tuple[int, Beacon]]:
    """The beacons in whole frames, with their senders' system ids."""
    if FLEET_BEACON.to_bytes(3, "little") not in data:
        return
    for message_id, system, _, frame in frames(data):
        if message_id != FLEET_BEACON:
            continue
        payload = frame[HEADER[MAGIC_2] : HEADER[MAGIC_2] + frame[1]].ljust(_BEACON.size, b"\0")
        yield system, beacon_of(_BEACON.unpack(payload))


def beacon_of(fields: tuple[int, ...]) -> Beacon:
    """A beacon from its fields, in the order of the wire."""
    _, epoch, digest, item, flags, follows, _ = fields
    return Beacon(epoch, bool(flags & 1), bool(flags & 2), follows, item, digest)


def digest_of(message: bytes) -> int:
    """The digest of a FLEET_TABLE frame, as beacons report it.

    FNV-1a, folded to 15 bits; the highest bit is set for a table that stops the boats.
    """
    payload = _payload(message)
    value = 2166136261
    move, share, members = payload[4:8], payload[9:10], payload[_TABLE.size :]
    flags = payload[8] & (_TURNS | _STOP | _ASSIGN)
    for byte in bytes([flags]) + move + share + members:
        value = (value ^ byte) * 16777619 & 0xFFFFFFFF
    return (value ^ value >> 16) & 0x7FFF | 0x8000 * bool(flags & _STOP)


def _payload(frame: bytes) -> bytes:
    """The payload of a FLEET_TABLE frame, with the zeros that MAVLink 2 leaves out."""
    payload = frame[HEADER[MAGIC_2] : HEADER[MAGIC_2] + frame[1]].ljust(_TABLE_BYTES, b"\0")
    return payload[:_TABLE_BYTES]


def _packed(member: Member) -> bytes:
    flags = _ONLY_LEADS if member.only_leads else _CAN_LEAD * member.can_lead
    place_cm = [round(100 * metres) for metres in member.place_m]
    length_dm = round(10 * member.length_m)
    return _MEMBER.pack(member.system, member.leader, flags, length_dm, *place_cm)


def _frame(message_id: int, payload: bytes, sender: tuple[int, int]) -> bytes:
    body = bytes([len(payload), 0, 0, 0, *sender]) + message_id.to_bytes(3, "little") + payload
    checksum = x25crc(body + bytes([SEEDS[message_id]])).crc
    return bytes([MAGIC_2]) + body + struct.pack("<H", checksum)
