# SPDX-License-Identifier: MIT
"""A serial line, raw and non-blocking: `/dev/…[:BAUD]`, 57,600 Bd by default."""

import os
import termios
import tty
from pathlib import Path

_BAUD = 57600


def line_of(address: str) -> tuple[Path, int]:
    """Parse DEVICE[:BAUD] into device and speed constant; ValueError if invalid."""
    device, _, baud = address.partition(":")
    speed = getattr(termios, f"B{baud or _BAUD}", None)
    if speed is None:
        raise ValueError(
            f"{baud} is not a baud rate of a serial line; use 57600 or 115200, for example"
        )
    return Path(device), speed


def open_line(device: Path, speed: int, access: int = os.O_RDONLY) -> int:
    """Open a serial line, for reading only unless `access` is O_RDWR; return its descriptor."""
    line = os.open(device, access | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        tty.setraw(line)
        settings = termios.tcgetattr(line)
        settings[4] = settings[5] = speed
        termios.tcsetattr(line, termios.TCSANOW, settings)
    except termios.error:
        os.close(line)
        raise
    return line
