# SPDX-License-Identifier: MIT
"""The DroneCAN messages that a boat and its ESCs exchange, as frozen dataclasses.

Source: DSDL of the DroneCAN standard types; classic CAN, so the last array has no length (tail
array optimisation). Fields longer than a byte are little-endian, bits of a partial byte first bit
highest. `decode` raises ValueError on a payload of the wrong length; `encode` saturates numbers.
"""

from dataclasses import dataclass
from struct import Struct

from sil.wire.dronecan_transfer import DataType

RAW_COMMAND = DataType(1030, 0x217F5C87D7EC951D)
ESC_STATUS = DataType(1034, 0xA9AF28AEA2FBB254)
ARMING_STATUS = DataType(1100, 0x8700F375556A8003)
NODE_STATUS = DataType(341, 0x0F0868D0C1A7C6F1)
GET_NODE_INFO = DataType(1, 0xEE468A8121C46A9E)

ARMED = 255
HEALTH_OK = 0
MODE_OPERATIONAL = 0

_F16_MAX = 65504.0
# Signed value of each 14-bit field, as encoded in the stream (low byte, then the 6 upper bits).
_INT14 = [((w & 0x3F) << 8 | w >> 6) - ((w & 0x20) << 9) for w in range(1 << 14)]
_SHIFTS = [range(8 * n - 14, -1, -14) for n in range(36)]


def _check_length(payload: bytes, length: int, name: str) -> None:
    if len(payload) != length:
        raise ValueError(f"{name} of {len(payload)} bytes")


@dataclass(frozen=True, slots=True)
class RawCommand:
    """esc.RawCommand: at most 20 values in [-8192, 8191], full reverse to full forward."""

    cmd: tuple[int, ...]

    def encode(self) -> bytes:
        """14 bits per value, saturated; ValueError for more than 20 values."""
        if len(self.cmd) > 20:
            raise ValueError(f"RawCommand of {len(self.cmd)} values")
        bits = 0
        for wanted in self.cmd:
            value = min(max(wanted, -8192), 8191)
            bits = bits << 14 | (value & 0xFF) << 6 | value >> 8 & 0x3F
        length = 14 * len(self.cmd)
        return (bits << -length % 8).to_bytes((length + 7) // 8, "big")

    @staticmethod
    def decode(payload: bytes) -> "RawCommand":
        """As many values as fit into the payload."""
        if len(payload) > 35:
            raise ValueError(f"RawCommand of {len(payload)} bytes")
        bits = int.from_bytes(payload, "big")
        return RawCommand(tuple([_INT14[bits >> s & 0x3FFF] for s in _SHIFTS[len(payload)]]))


@dataclass(frozen=True, slots=True)
class ArmingStatus:
    """safety.ArmingStatus: 0 disarmed, 255 fully armed."""

    status: int

    def encode(self) -> bytes:
        """One byte."""
        return bytes((min(max(self.status, 0), 255),))

    @staticmethod
    def decode(payload: bytes) -> "ArmingStatus":
        """One byte."""
        _check_length(payload, 1, "ArmingStatus")
        return ArmingStatus(payload[0])


_NODE_STATUS = Struct("<IBH")


@dataclass(frozen=True, slots=True)
class NodeStatus:
    """protocol.NodeStatus: health 0 OK … 3 critical, mode 0 operational … 7 offline."""

    uptime_s: int
    health: int = HEALTH_OK
    mode: int = MODE_OPERATIONAL
    sub_mode: int = 0
    vendor_code: int = 0

    def encode(self) -> bytes:
        """Seven bytes: one frame."""
        health, mode = min(max(self.health, 0), 3), min(max(self.mode, 0), 7)
        return _NODE_STATUS.pack(
            min(max(self.uptime_s, 0), 0xFFFFFFFF),
            health << 6 | mode << 3 | min(max(self.sub_mode, 0), 7),
            min(max(self.vendor_code, 0), 0xFFFF),
        )

    @staticmethod
    def decode(payload: bytes) -> "NodeStatus":
        """Seven bytes."""
        _check_length(payload, 7, "NodeStatus")
        uptime_s, state, vendor_code = _NODE_STATUS.unpack(payload)
        return NodeStatus(uptime_s, state >> 6, state >> 3 & 7, state & 7, vendor_code)


_ESC_STATUS = Struct("<IeeeHBB")


def _float16(value: float) -> float:
    # This order of arguments keeps NaN, with which every comparison is false.
    return min(max(value, -_F16_MAX), _F16_MAX)


@dataclass(frozen=True, slots=True)
class EscStatus:
    """esc.Status: an unknown voltage (V), current (A) or temperature (K) is NaN; rpm is 1/min."""

    error_count: int
    voltage_V: float
    current_A: float
    temperature_K: float
    rpm: int
    power_pct: int
    esc_index: int

    def encode(self) -> bytes:
        """Fourteen bytes; numbers are float16, to nearest, saturated at ±65504."""
        rpm = min(max(self.rpm, -131072), 131071)
        power = min(max(self.power_pct, 0), 127)
        return _ESC_STATUS.pack(
            min(max(self.error_count, 0), 0xFFFFFFFF),
            _float16(self.voltage_V),
            _float16(self.current_A),
            _float16(self.temperature_K),
            rpm & 0xFFFF,
            (rpm >> 10 & 0xC0) | power >> 1,
            (power & 1) << 7 | min(max(self.esc_index, 0), 31) << 2,
        )

    @staticmethod
    def decode(payload: bytes) -> "EscStatus":
        """Fourteen bytes."""
        _check_length(payload, 14, "esc.Status")
        errors, voltage_V, current_A, temperature_K, low, high, last = _ESC_STATUS.unpack(payload)
        rpm = (high & 0x40) << 10 | low
        rpm -= (high & 0x80) << 10
        power = (high & 0x3F) << 1 | last >> 7
        return EscStatus(errors, voltage_V, current_A, temperature_K, rpm, power, last >> 2 & 0x1F)


_NODE_INFO = Struct("<7sBBBIQBB16sB")


@dataclass(frozen=True, slots=True)
class NodeInfo:
    """The response of protocol.GetNodeInfo; its request is empty. `name` is at most 80 bytes."""

    status: NodeStatus
    name: bytes
    unique_id: bytes
    software: tuple[int, int] = (0, 0)
    software_flags: int = 0
    vcs_commit: int = 0
    image_crc: int = 0
    hardware: tuple[int, int] = (0, 0)
    certificate: bytes = b""

    def encode(self) -> bytes:
        """ValueError if the name, unique id or certificate has a length that does not fit."""
        if len(self.name) > 80 or len(self.unique_id) != 16 or len(self.certificate) > 255:
            raise ValueError("NodeInfo: name, unique id or certificate has the wrong length")
        fixed = _NODE_INFO.pack(
            self.status.encode(),
            *self.software,
            self.software_flags,
            self.vcs_commit,
            self.image_crc,
            *self.hardware,
            self.unique_id,
            len(self.certificate),
        )
        return fixed + self.certificate + self.name

    @staticmethod
    def decode(payload: bytes) -> "NodeInfo":
        """The name is the rest after the certificate; ValueError for a wrong length."""
        if len(payload) < _NODE_INFO.size:
            raise ValueError(f"NodeInfo of {len(payload)} bytes")
        status, s0, s1, flags, commit, crc, h0, h1, unique_id, length = _NODE_INFO.unpack_from(
            payload
        )
        end = _NODE_INFO.size + length
        if not end <= len(payload) <= end + 80:
            raise ValueError(f"NodeInfo of {len(payload)} bytes, certificate of {length}")
        return NodeInfo(
            NodeStatus.decode(status),
            payload[end:],
            unique_id,
            (s0, s1),
            flags,
            commit,
            crc,
            (h0, h1),
            payload[_NODE_INFO.size : end],
        )
