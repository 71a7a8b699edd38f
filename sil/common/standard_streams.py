# SPDX-License-Identifier: MIT
"""Standard output and standard error that end no command: `flotilla run diamond | head -1`."""

import io
import sys
from typing import Any


def make_patient() -> None:
    """Replace the streams of this process that lead to a pipe or a file.

    Output that nobody reads any more, or that a full disk does not hold, is dropped, so that a
    command completes its files all the same. A character that the encoding of standard output lacks
    becomes "?".
    """
    for name, number in (("stdout", 1), ("stderr", 2)):
        stream = getattr(sys, name)
        own = stream is getattr(sys, f"__{name}__")  # not a test's
        if own and isinstance(stream, io.TextIOWrapper) and not stream.isatty():
            stream.flush()
            setattr(sys, name, _patient(name, stream, number))


def check() -> None:
    """OSError if standard output could not be written, unless its reader has left."""
    if not isinstance(sys.stdout, io.TextIOWrapper):
        return
    sys.stdout.flush()
    pipe = getattr(sys.stdout.buffer, "raw", None)
    if isinstance(pipe, _Pipe) and pipe.lost and not isinstance(pipe.lost, BrokenPipeError):
        pipe.lost.filename = "standard output"
        raise pipe.lost


def _patient(name: str, stream: io.TextIOWrapper, number: int) -> io.TextIOWrapper:
    return io.TextIOWrapper(
        io.BufferedWriter(_Pipe(number, "w", closefd=False)),
        encoding=stream.encoding,
        errors="replace" if name == "stdout" else stream.errors,
        line_buffering=stream.line_buffering,
        write_through=stream.write_through,
    )


class _Pipe(io.FileIO):
    lost: OSError | None = None

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except OSError as error:
            self.lost = self.lost or error
            return len(memoryview(data))
