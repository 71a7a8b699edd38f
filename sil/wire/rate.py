# SPDX-License-Identifier: MIT
"""Schedule of a periodic message."""


class Rate:
    """A grid of instants, `hz` per second, anchored at the first call of `due`.

    Instants are computed in whole microseconds from the anchor, so the grid never drifts, whatever
    the clock's offset. A late call gets one message and leaves the grid as it is; two periods late,
    or a clock that ran backwards, starts a new grid.
    """

    def __init__(self, hz: float) -> None:
        self._hz = hz
        self._period_us = round(1e6 / hz)
        self._anchor_us = 0
        self._count = 0
        self._next_us = -(1 << 62)

    def due(self, now_us: int) -> bool:
        """Whether to send the message at `now_us` (us, the caller's clock)."""
        late_us = now_us - self._next_us
        if -self._period_us <= late_us < 0:
            return False
        # With less than two periods, a clock that jitters by 1 us around the grid would lose slots.
        if not 0 <= late_us < 2 * self._period_us:
            self._anchor_us = now_us
            self._count = 0
        self._count += 1
        self._next_us = self._anchor_us + int(self._count * 1e6 / self._hz)
        return True
