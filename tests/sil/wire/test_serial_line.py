# SPDX-License-Identifier: MIT
"""A serial line belongs to one program at a time."""

import errno
import fcntl
import os
import pty
import struct
import termios
from collections.abc import Iterator
from pathlib import Path

import pytest

from sil.view.alarm import of_error
from sil.wire.serial_line import line_of, open_line


@pytest.fixture
def device() -> Iterator[str]:
    master, slave = pty.openpty()
    yield os.ttyname(slave)
    os.close(master)
    os.close(slave)


def test_an_open_serial_line_is_busy_for_others_until_it_is_closed(device: str) -> None:
    line = open_line(*line_of(device))
    with pytest.raises(OSError, match="busy") as error:
        open_line(*line_of(device), os.O_RDWR)
    assert error.value.errno == errno.EBUSY
    assert of_error(error.value) == "another program uses it; close that program"
    fcntl.ioctl(line, termios.TIOCNXCL)  # as a real line, which nobody else keeps open here
    os.close(line)
    os.close(open_line(*line_of(device)))


def test_a_program_that_does_not_lock_is_kept_out_too(device: str) -> None:
    line = open_line(*line_of(device))
    (exclusive,) = struct.unpack("i", fcntl.ioctl(line, 0x80045440, bytes(4)))  # TIOCGEXCL
    assert exclusive == 1
    os.close(line)


def test_a_file_is_no_line(tmp_path: Path) -> None:
    path = tmp_path / "file"
    path.touch()
    with pytest.raises(OSError, match="ioctl") as error:
        open_line(path, termios.B57600)
    assert "not a serial line" in of_error(error.value)
