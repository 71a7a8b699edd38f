# SPDX-License-Identifier: MIT
"""What the page plays back: columns over time, and what changed when."""

import base64
from collections.abc import Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

MOST_SAMPLES = 1200

History = dict[str, Any]
"""{"title", "t_s": column, "vessels": [{"id", "kind", "length_m", "limits_N", "leader", columns,
"states", "held", "texts": [[t_s, what], …]}]}; a column is base64 of little-endian float32, NaN
where nothing is known."""


def column(values: npt.ArrayLike) -> str:
    """A column of numbers."""
    return base64.b64encode(np.asarray(values, "<f4").tobytes()).decode()


def numbers(column_: str) -> npt.NDArray[np.float32]:
    """The numbers of a column."""
    return np.frombuffer(base64.b64decode(column_), "<f4")


def thinned(count: int) -> npt.NDArray[np.int64]:
    """Which of `count` samples are kept: the first, the last and what is evenly between them."""
    kept = min(count, MOST_SAMPLES)
    return np.linspace(0, count - 1, kept).round().astype(np.int64)


class Changes:
    """What changed when: [[t_s, what], …], an entry for each change."""

    def __init__(self) -> None:
        self.list: list[list[Any]] = []

    def note(self, t_s: float, what: Any) -> None:
        """It is so at `t_s`; None is not known."""
        if what is None or (self.list and self.list[-1][1] == what):
            return
        self.list.append([round(t_s, 3), what])


def known(values: Sequence[float | None]) -> list[float]:
    """Numbers with NaN for None."""
    return [float("nan") if value is None else value for value in values]
