# SPDX-License-Identifier: MIT
"""Result files: written atomically; JSON contains no NaN."""

import math
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO


def check_folder(folder: Path, told: Path) -> None:
    """Check that `folder` is writable or can be made, leaving no file; OSError names `told`."""
    with naming(told):
        there = next(path for path in (folder, *folder.parents) if os.path.lexists(path))
        tempfile.TemporaryFile(dir=there).close()


def replace(path: Path, content: bytes) -> None:
    """Write `path` as `whole` does."""
    with whole(path) as file:
        file.write(content)


def is_replaced(path: Path) -> bool:
    """Whether `whole` replaces `path`; it writes to a device, pipe or link."""
    return not path.is_symlink() and (path.is_file() or not path.exists())


@contextmanager
def whole(path: Path) -> Iterator[BinaryIO]:
    """A file to write, which becomes `path` at the end, or is removed after an error.

    A device, pipe or link is written to, not replaced. OSError names `path`.
    """
    replaces = is_replaced(path)
    part = path.with_name(f".{path.name}.part") if replaces else path
    try:
        with naming(path):
            with part.open("wb") as file:
                yield file
            if replaces:
                os.replace(part, path)
    finally:
        if replaces:
            part.unlink(missing_ok=True)


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Make errors about files name `path`."""
    try:
        yield
    except OSError as error:
        error.filename, error.filename2 = str(path), None
        raise


def plain(value: Any) -> Any:
    """Convert a value for JSON: complex to [real, imaginary], non-finite numbers to null."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, complex):
        return [plain(value.real), plain(value.imag)]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
