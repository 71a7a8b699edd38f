# SPDX-License-Identifier: MIT
"""trace.npz of a run's folder; its arrays: see `sil.lockstep.metrics`."""

import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from sil.plant.hull import Array

NAME = "trace.npz"
_ARRAYS = ("t_s", "eta", "nu", "error", "thrust")
_DAMAGE = (EOFError, KeyError, ValueError, zipfile.BadZipFile, zlib.error)


def read(folder: Path, names: Sequence[str] = _ARRAYS) -> dict[str, Array]:
    """Arrays of a folder's trace; OSError, or ValueError in one line if it is damaged."""
    path = folder / NAME
    try:
        # numpy would leave a damaged file open
        with path.open("rb") as stream, np.load(stream) as arrays:
            trace = {name: arrays[name] for name in names}
    except _DAMAGE:
        raise ValueError(f"{path} is damaged: sail the run again") from None
    if not trace["t_s"].size:
        raise ValueError(f"{path} is empty: sail the run again, for at least a tick")
    return trace
