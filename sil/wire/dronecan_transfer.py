# SPDX-License-Identifier: MIT
"""DroneCAN v0 transfers on classic CAN: identifiers, tail bytes, CRC, reassembly.

Source: DroneCAN specification, chapter 4.1. Written independently of the firmware's codec, so that
a mistake in one cannot cancel in the other. CAN identifiers have 29 bits, data at most 8 bytes.
"""

from binascii import crc_hqx
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

TRANSFER_ID_TIMEOUT_US = 2_000_000
MAX_PAYLOAD = 512

_START, _END, _TOGGLE, _ID = 0x80, 0x40, 0x20, 0x1F
_SINGLE_TAIL = [bytes([_START | _END | i]) for i in range(32)]


class Kind(Enum):
    """The kind of transfer that a frame belongs to."""

    MESSAGE = "message"
    ANONYMOUS = "anonymous"
    REQUEST = "request"
    RESPONSE = "response"


@dataclass(frozen=True)
class DataType:
    """A data type's number and its 64-bit signature, which seeds the transfer CRC."""

    type_id: int
    signature: int

    @property
    def crc_seed(self) -> int:
        """CRC-16-CCITT-FALSE of the signature, little-endian."""
        return crc_hqx(self.signature.to_bytes(8, "little"), 0xFFFF)


@dataclass(frozen=True)
class FrameId:
    """A CAN identifier's fields; `destination`: services only, `discriminator`: anonymous only."""

    kind: Kind
    priority: int
    type_id: int
    source: int = 0
    destination: int = 0
    discriminator: int = 0

    def pack(self) -> int:
        """The 29-bit identifier; ValueError when a field is out of range."""
        if self.kind is Kind.MESSAGE:
            can_id = self.type_id << 8
        elif self.kind is Kind.ANONYMOUS:
            can_id = self.discriminator << 10 | self.type_id << 8
        else:
            request = self.kind is Kind.REQUEST
            can_id = self.type_id << 16 | request << 15 | self.destination << 8 | 0x80
        can_id |= self.priority << 24 | self.source
        if FrameId.unpack(can_id) != self:
            raise ValueError(f"{self} does not fit into a CAN identifier")
        return can_id

    @staticmethod
    def unpack(can_id: int) -> "FrameId":
        """Parse a 29-bit identifier; an anonymous frame has only the low 2 bits of its type."""
        priority, source = can_id >> 24 & 0x1F, can_id & 0x7F
        if can_id & 0x80:
            kind = Kind.REQUEST if can_id & 0x8000 else Kind.RESPONSE
            return FrameId(kind, priority, can_id >> 16 & 0xFF, source, can_id >> 8 & 0x7F)
        if source:
            return FrameId(Kind.MESSAGE, priority, can_id >> 8 & 0xFFFF, source)
        return FrameId(
            Kind.ANONYMOUS, priority, can_id >> 8 & 3, discriminator=can_id >> 10 & 0x3FFF
        )


def message_subject(data_type: DataType) -> int:
    """The bits of an identifier that all frames of a message type share (see `Receiver`)."""
    return data_type.type_id << 8


def service_subject(data_type: DataType, destination: int, *, request: bool) -> int:
    """The bits of an identifier that a service's frames to one node share (see `Receiver`)."""
    return data_type.type_id << 16 | request << 15 | destination << 8 | 0x80


def split(payload: bytes, transfer_id: int, crc_seed: int) -> list[bytes]:
    """The frames' data of one transfer, in order; a multi-frame transfer begins with its CRC."""
    if len(payload) <= 7:
        return [payload + _SINGLE_TAIL[transfer_id]]
    stream = crc_hqx(payload, crc_seed).to_bytes(2, "little") + payload
    frames, toggle, flags = [], 0, _START
    for at in range(0, len(stream), 7):
        if at + 7 >= len(stream):
            flags |= _END
        frames.append(stream[at : at + 7] + bytes((flags | toggle | transfer_id,)))
        toggle, flags = toggle ^ _TOGGLE, 0
    return frames


class Publisher:
    """Sends one message type from one node, with consecutive transfer ids."""

    def __init__(self, data_type: DataType, priority: int, source: int) -> None:
        self._can_id = FrameId(Kind.MESSAGE, priority, data_type.type_id, source).pack()
        self._crc_seed = data_type.crc_seed
        self._transfer_id = 0

    def frames(self, payload: bytes) -> list[tuple[int, bytes]]:
        """The next transfer's frames: identifier and data."""
        transfer_id = self._transfer_id
        self._transfer_id = (transfer_id + 1) & _ID
        can_id = self._can_id
        return [(can_id, data) for data in split(payload, transfer_id, self._crc_seed)]


class _Session:
    """The receiver's state for one type, kind, source and destination."""

    __slots__ = ("open", "payload", "start_us", "toggle", "transfer_id")

    def __init__(self) -> None:
        self.start_us = -(1 << 62)
        self.transfer_id = 0
        self.restart(0)

    def restart(self, transfer_id: int) -> None:
        self.transfer_id = transfer_id & _ID
        self.toggle = 0
        self.open = False
        self.payload = b""


class Receiver:
    """Reassembles transfers of the accepted subjects and ignores all others.

    `accepted` maps a subject (an identifier without priority and source) to its type; each source
    has its own session. `counters` counts rejected frames and transfers: `malformed`, `unexpected`
    (repeated, reordered or without a start), `oversize`, `crc`.
    """

    def __init__(self, accepted: Mapping[int, DataType]) -> None:
        self.counters: Counter[str] = Counter()
        self._seeds = {subject: data_type.crc_seed for subject, data_type in accepted.items()}
        self._sessions: dict[int, _Session] = {}

    def on_frame(self, can_id: int, data: bytes, now_us: int) -> bytes | None:
        """Process a frame (receiver's clock, us); return the payload if it completes a transfer."""
        subject = can_id & 0xFFFF80
        if not can_id & 0x7F:
            subject &= 0x380
        seed = self._seeds.get(subject)
        if seed is None:
            return None
        if not 0 < len(data) <= 8 or can_id >> 29:
            return self._refuse("malformed")
        tail = data[-1]
        if not can_id & 0x7F:
            # Anonymous transfers are single frames without session state.
            return data[:-1] if tail & 0xE0 == _START | _END else self._refuse("malformed")
        session = self._sessions.get(can_id & 0xFFFFFF)
        if session is None:
            session = self._sessions[can_id & 0xFFFFFF] = _Session()

        transfer_id = tail & _ID
        start = tail >= _START
        if now_us - session.start_us > TRANSFER_ID_TIMEOUT_US or (
            start and (session.transfer_id - transfer_id) & _ID > 1
        ):
            if not start:
                return self._refuse("unexpected")
            session.restart(transfer_id)
        if (
            tail & _TOGGLE != session.toggle
            or transfer_id != session.transfer_id
            # Not in the specification: a start inside a transfer, or a transfer without a start.
            or start is session.open
        ):
            return self._refuse("unexpected")
        if start:
            session.start_us = now_us
            if tail & _END:
                session.transfer_id = (transfer_id + 1) & _ID
                return data[:-1]
            session.open = True
        session.payload += data[:-1]
        session.toggle ^= _TOGGLE
        if tail & _END:
            return self._close(session, seed)
        if len(session.payload) > MAX_PAYLOAD:
            session.restart(transfer_id + 1)
            return self._refuse("oversize")
        return None

    def _close(self, session: _Session, seed: int) -> bytes | None:
        stream = session.payload
        session.restart(session.transfer_id + 1)
        if crc_hqx(stream[2:], seed).to_bytes(2, "little") != stream[:2]:
            return self._refuse("crc")
        return stream[2:]

    def _refuse(self, reason: str) -> bytes | None:
        self.counters[reason] += 1
        return None
