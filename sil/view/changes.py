# SPDX-License-Identifier: MIT
"""Step-wise values of a history: [t_s, value], each valid from its time on."""

from typing import Any


class Changes:
    """One entry per change; before t_s = 0 only the last."""

    def __init__(self) -> None:
        self.list: list[list[Any]] = []

    def note(self, t_s: float, value: Any) -> None:
        """Note the value at `t_s`; None, for unknown, is ignored."""
        if value is None:
            return
        if t_s <= 0.0:
            self.list.clear()
        if not self.list or self.list[-1][1] != value:
            self.list.append([round(t_s, 3), value])
