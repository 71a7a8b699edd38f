# SPDX-License-Identifier: MIT
"""A serial line, raw and non-blocking: `/dev/…[:BAUD]`, 57,600 Bd by default."""

import errno
import fcntl
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
    """Open a serial line for this program alone; return its descriptor.

    For reading only unless `access` is O_RDWR. OSError: EBUSY if another program has the line,
    since two that read would each get a part of the bytes.
    """
    line = os.open(device, access | os.O_NOCTTY | os.O_NONBLOCK)
    try:
        fcntl.flock(line, fcntl.LOCK_EX | fcntl.LOCK_NB)
        fcntl.ioctl(line, termios.TIOCEXCL)  # for programs that do not lock
        tty.setraw(line)
        settings = termios.tcgetattr(line)
        settings[4] = settings[5] = speed
        termios.tcsetattr(line, termios.TCSANOW, settings)
    except BlockingIOError:
        os.close(line)
        raise OSError(errno.EBUSY, os.strerror(errno.EBUSY), str(device)) from None
    except (OSError, termios.error) as error:
        os.close(line)
        raise OSError(*error.args) from None
    return line
