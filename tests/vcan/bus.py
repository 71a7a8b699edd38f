# SPDX-License-Identifier: MIT
"""Access to vcan0 for tests: raw sockets, candump, system programs."""

import select
import socket
import struct
import subprocess
from contextlib import closing, suppress
from typing import Self

from tests.target.bus import Frames

INTERFACE = "vcan0"
#: Priority of our sockets, by which tc can distinguish their frames from the boat's.
URGENT = 6

_FRAME = struct.Struct("=IB3x8s")
_PATIENCE_S = 5.0


def run(*command: str) -> None:
    """Run a system program: ip, tc, cansend."""
    subprocess.run(command, check=True)


class Can:
    """A raw socket on vcan0 that survives the loss of its interface."""

    def __init__(self, filters: list[tuple[int, int]] | None = None) -> None:
        self._filters = filters
        self.socket = self._open()

    def _open(self) -> socket.socket:
        can = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        can.setsockopt(socket.SOL_SOCKET, socket.SO_PRIORITY, URGENT)
        if self._filters is not None:
            packed = b"".join(struct.pack("=II", *each) for each in self._filters)
            can.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, packed)
        can.setblocking(False)
        can.bind((INTERFACE,))
        return can

    def close(self) -> None:
        self.socket.close()

    def reopen(self) -> None:
        """Reopen after the interface was recreated."""
        self.close()
        self.socket = self._open()

    def send(self, can_id: int, data: bytes) -> None:
        """Send a frame; it is lost if the interface is down or full."""
        with suppress(OSError):
            self.send_raw(can_id | socket.CAN_EFF_FLAG, data)

    def send_raw(self, can_id: int, data: bytes) -> None:
        self.socket.send(_FRAME.pack(can_id, len(data), data))

    def receive(self) -> Frames:
        frames = []
        with suppress(OSError):
            while True:
                can_id, size, data = _FRAME.unpack(self.socket.recv(_FRAME.size))
                frames.append((can_id & socket.CAN_EFF_MASK, data[:size]))
        return frames


class Candump:
    """candump (can-utils) on vcan0; a context manager."""

    def __init__(self) -> None:
        self._process = subprocess.Popen(
            ["candump", "-L", INTERFACE], stdout=subprocess.PIPE, text=True, pipesize=1 << 20
        )

    def __enter__(self) -> Self:
        """Wait until candump receives."""
        assert self._process.stdout is not None
        with closing(Can([])) as can:
            for _ in range(round(_PATIENCE_S / 0.05)):
                can.send_raw(0x123, b"")
                if select.select([self._process.stdout], [], [], 0.05)[0]:
                    return self
        self.__exit__()
        raise AssertionError("candump hears nothing")

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        if self._process.stdout is not None:
            self._process.stdout.close()

    def frames(self) -> list[tuple[float, int, bytes]]:
        """End candump; time (s), identifier and data of every frame with a 29-bit identifier."""
        self._process.terminate()
        frames = []
        for line in self._process.communicate()[0].splitlines():
            stamp, _, frame = line.split()
            can_id, _, data = frame.partition("#")
            if len(can_id) == 8:
                frames.append((float(stamp.strip("()")), int(can_id, 16), bytes.fromhex(data)))
        return frames
