# SPDX-License-Identifier: MIT
"""Result files: written atomically; JSON contains no NaN."""

import math
import os
from pathlib import Path
from typing import Any


def replace(path: Path, content: bytes) -> None:
    """Write `path` atomically; a device, pipe or link is written to, not replaced."""
    if path.is_symlink() or (path.exists() and not path.is_file()):
        path.write_bytes(content)
        return
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(content)
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


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
