# SPDX-License-Identifier: MIT
"""What the page plays back: columns over time, and what changed when."""

import base64
from typing import Any

import numpy as np
import numpy.typing as npt

MOST_SAMPLES = 1200
_LEAST_SAMPLES = 100
_MOST_POSES = 100_000  # of all vessels: a thousand boats are a page of some 10 MB

History = dict[str, Any]
"""{"title", "t_s": column, "vessels": [{"id", "kind", "length_m", "limits_N", "leader", columns,
"states", "held", "texts": [[t_s, what], …]}]}; a column is base64 of little-endian float32, NaN
where nothing is known."""


def column(values: npt.ArrayLike) -> str:
    """A column of numbers."""
    return base64.b64encode(np.asarray(values, "<f4").tobytes()).decode()


def numbers(text: str) -> npt.NDArray[np.float32]:
    """The numbers of a column."""
    return np.frombuffer(base64.b64decode(text), "<f4")


def most_samples(vessels: int) -> int:
    """How many samples a history of so many vessels has at most."""
    return max(_LEAST_SAMPLES, min(MOST_SAMPLES, _MOST_POSES // max(1, vessels)))


def thinned(count: int, vessels: int) -> npt.NDArray[np.int64]:
    """Which of `count` samples are kept: the first, the last and what is evenly between them."""
    kept = min(count, most_samples(vessels))
    return np.linspace(0, count - 1, kept).round().astype(np.int64)


class Changes:
    """What changed when: [[t_s, what], …], an entry for each change; of what was at t_s 0, one."""

    def __init__(self) -> None:
        self.list: list[list[Any]] = []

    def note(self, t_s: float, what: Any) -> None:
        """It is so at `t_s`; None: it is not known."""
        if what is None:
            return
        if t_s <= 0.0:
            self.list.clear()
        if not self.list or self.list[-1][1] != what:
            self.list.append([round(t_s, 3), what])
