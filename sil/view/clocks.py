# SPDX-License-Identifier: MIT
"""The clocks in a vessel's messages: distinguishes a restart, a late message and a second vessel.

A message that arrives at t, with the time b since its sender's start, gives t − b as the start. A
late message gives too late a start; two vessels with one system id give two starts in turn.
"""

from collections import deque
from dataclasses import dataclass

_SAME_S = 2.0  # two starts nearer than that are one
_LASTS, _LASTS_S = 3, 1.0  # messages, s: then another clock becomes the vessel's
_TURNS, _TURNS_S = 3, 10.0  # changes between two clocks, s: these mean two vessels


@dataclass
class _Other:
    """Another clock: its start, when it was first heard, and how often in a row."""

    start_s: float
    since_s: float
    times: int = 0


class Clocks:
    """The clocks heard; two vessels that started within 2 s of each other count as one."""

    def __init__(self) -> None:
        self._start_s: float | None = None
        self._other: _Other | None = None
        self._turns_s: deque[float] = deque(maxlen=_TURNS)

    @property
    def strange(self) -> int:
        """Number of the last messages that came from another clock than the vessel's."""
        return 0 if self._other is None else self._other.times

    def are_two(self, now_s: float) -> bool:
        """Whether two vessels have sent in turn within the last 10 s."""
        turns_s = self._turns_s
        return len(turns_s) == _TURNS and now_s - turns_s[0] < _TURNS_S

    def hear(self, boot_ms: int, now_s: float) -> bool:
        """Process a message; whether its vessel was restarted: a new clock has persisted."""
        start_s, other = now_s - 0.001 * boot_ms, self._other
        if self._start_s is None or abs(start_s - self._start_s) < _SAME_S:
            self._start_s = start_s
            if other is not None and other.times:
                self._turns_s.append(now_s)
                other.times = 0
            return False
        if other is None or abs(start_s - other.start_s) >= _SAME_S:
            other = self._other = _Other(start_s, now_s)
            self._turns_s.clear()
        if not other.times:
            other.since_s = now_s
        other.start_s, other.times = start_s, other.times + 1
        lasts = other.times >= _LASTS and now_s - other.since_s >= _LASTS_S
        if not lasts or self.are_two(now_s):
            return False
        # an earlier start is no restart: the messages before were late
        restarted = start_s > self._start_s
        self._start_s, self._other = start_s, None
        self._turns_s.clear()
        return restarted
