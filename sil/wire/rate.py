# SPDX-License-Identifier: MIT
"""When a periodic message is due."""


class Rate:
    """A grid of instants, `hz` times a second (1/s), anchored at the first question.

    The grid is counted in whole microseconds from its anchor, so it never drifts, whatever the
    clock's offset. A question that comes late is answered once and the grid stays; two periods
    late, or a clock that ran backwards, anchors it anew.
    """

    def __init__(self, hz: float) -> None:
        self._hz = hz
        self._period_us = round(1e6 / hz)
        self._anchor_us = 0
        self._count = 0
        self._next_us = -(1 << 62)

    def due(self, now_us: int) -> bool:
        """Whether the message is to be sent at `now_us` (us, the asker's clock)."""
        late_us = now_us - self._next_us
        if -self._period_us <= late_us < 0:
            return False
        # Less than two periods would let a clock that jitters by 1 us around the grid lose slots.
        if not 0 <= late_us < 2 * self._period_us:
            self._anchor_us = now_us
            self._count = 0
        self._count += 1
        self._next_us = self._anchor_us + int(self._count * 1e6 / self._hz)
        return True
