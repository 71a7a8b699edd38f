# SPDX-License-Identifier: MIT
"""The DroneCAN side of a motor controller: its command to the motor and its frames on the bus.

Behaves as AM32 firmware with its default settings: thrust only while armed, after a zero command,
and while commands keep coming.
"""

from sil.wire.dronecan import (
    ARMED,
    ARMING_STATUS,
    ESC_STATUS,
    GET_NODE_INFO,
    NODE_STATUS,
    RAW_COMMAND,
    ArmingStatus,
    EscStatus,
    NodeInfo,
    NodeStatus,
    RawCommand,
)
from sil.wire.dronecan_transfer import (
    FrameId,
    Kind,
    Publisher,
    Receiver,
    message_subject,
    service_subject,
    split,
)
from sil.wire.rate import Rate

COMMAND_TIMEOUT_US = 250_000
ARMING_TIMEOUT_US = 500_000

_RAW_COMMAND = message_subject(RAW_COMMAND)
_ARMING_STATUS = message_subject(ARMING_STATUS)
_GET_NODE_INFO_SEED = GET_NODE_INFO.crc_seed
_NEVER_US = -(1 << 62)


class EscNode:
    """One ESC on the bus; times are of its own clock (us). Construct a new one to reboot it.

    `counters` counts rejected frames and payloads (see `Receiver`).
    """

    def __init__(
        self,
        node_id: int,
        esc_index: int,
        *,
        require_arming: bool = True,
        status_hz: float = 25.0,
        name: str = "org.flotilla.sil.esc",
    ) -> None:
        self._node_id = node_id
        self._esc_index = esc_index
        self._require_arming = require_arming
        self._name = name.encode()
        get_node_info = service_subject(GET_NODE_INFO, node_id, request=True)
        self._receiver = Receiver(
            {
                _RAW_COMMAND: RAW_COMMAND,
                _ARMING_STATUS: ARMING_STATUS,
                get_node_info: GET_NODE_INFO,
            }
        )
        self.counters = self._receiver.counters
        self._node_status = Publisher(NODE_STATUS, 20, node_id)
        self._esc_status = Publisher(ESC_STATUS, 16, node_id)
        self._node_status_rate = Rate(1.0)
        self._esc_status_rate = Rate(status_hz)
        self._info_requests: list[tuple[FrameId, int]] = []
        self._boot_us: int | None = None
        self._raw = 0
        self._raw_us = _NEVER_US
        self._armed_us = _NEVER_US
        self._zero_seen = False

    def on_can(self, can_id: int, data: bytes, now_us: int) -> None:
        """Takes one frame from the bus (29-bit identifier)."""
        payload = self._receiver.on_frame(can_id, data, now_us)
        if payload is None:
            return
        subject = can_id & 0xFFFF80
        try:
            if subject == _RAW_COMMAND:
                self._on_raw_command(RawCommand.decode(payload), now_us)
            elif subject == _ARMING_STATUS:
                armed = ArmingStatus.decode(payload).status == ARMED
                self._armed_us = now_us if armed else _NEVER_US
            else:
                self._info_requests.append((FrameId.unpack(can_id), data[-1] & 0x1F))
        except ValueError:
            self.counters["malformed"] += 1

    def _on_raw_command(self, message: RawCommand, now_us: int) -> None:
        if self._esc_index < len(message.cmd):
            self._raw = message.cmd[self._esc_index]
            self._raw_us = now_us
            self._zero_seen |= self._raw == 0

    def command(self, now_us: int) -> float:
        """The current command to the motor, full reverse -1 to full forward 1.

        Zero while disarmed (no ArmingStatus 255 for 0.5 s), while RawCommand has been silent for
        more than 250 ms, and until a zero RawCommand has been seen.
        """
        if not self._zero_seen or now_us - self._raw_us > COMMAND_TIMEOUT_US:
            return 0.0
        if self._require_arming and now_us - self._armed_us > ARMING_TIMEOUT_US:
            return 0.0
        return max(self._raw / 8191.0, -1.0)

    def tick(
        self, now_us: int, rpm: float, voltage_V: float, current_A: float
    ) -> list[tuple[int, bytes]]:
        """The frames due at `now_us`: identifier and data. `rpm` in 1/min, signed."""
        if self._boot_us is None:
            self._boot_us = now_us
        frames: list[tuple[int, bytes]] = []
        if self._node_status_rate.due(now_us):
            frames += self._node_status.frames(self._status(now_us).encode())
        if self._esc_status_rate.due(now_us):
            power_pct = round(100.0 * abs(self.command(now_us)))
            status = EscStatus(
                0, voltage_V, current_A, float("nan"), round(rpm), power_pct, self._esc_index
            )
            frames += self._esc_status.frames(status.encode())
        if self._info_requests:
            frames += self._answers(now_us)
        return frames

    def _status(self, now_us: int) -> NodeStatus:
        return NodeStatus((now_us - (self._boot_us or 0)) // 1_000_000)

    def _answers(self, now_us: int) -> list[tuple[int, bytes]]:
        unique_id = bytes((self._node_id, self._esc_index)) + b"flotilla.sil.e"
        payload = NodeInfo(self._status(now_us), self._name, unique_id, (1, 0)).encode()
        frames = []
        for asked, transfer_id in self._info_requests:
            can_id = FrameId(
                Kind.RESPONSE, asked.priority, asked.type_id, self._node_id, asked.source
            ).pack()
            frames += [(can_id, d) for d in split(payload, transfer_id, _GET_NODE_INFO_SEED)]
        self._info_requests = []
        return frames
