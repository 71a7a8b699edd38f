# SPDX-License-Identifier: MIT
"""Step-wise values of a history: [t_s, value], each valid from its time on."""

from typing import Any


class Changes:
    """One entry per change; before t_s = 0 only the last."""

    def __init__(self) -> None:
        self.list: list[list[Any]] = []

    def note(self, t_s: float, value: Any) -> None:
        """Note the value at `t_s`; None, for unknown, counts only after a known one."""
        before = self.list[-1][1] if self.list else None
        if value == before:
            return
        if t_s <= 0.0:
            self.list.clear()
        self.list.append([round(t_s, 3), value])
