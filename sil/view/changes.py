# SPDX-License-Identifier: MIT
"""What changes seldom, as a history has it: [t_s, value], each value true from its time on."""

from typing import Any


class Changes:
    """An entry for each change; of what was before t_s 0, the last."""

    def __init__(self) -> None:
        self.list: list[list[Any]] = []

    def note(self, t_s: float, value: Any) -> None:
        """It is so at `t_s`; None: it is not known."""
        if value is None:
            return
        if t_s <= 0.0:
            self.list.clear()
        if not self.list or self.list[-1][1] != value:
            self.list.append([round(t_s, 3), value])
