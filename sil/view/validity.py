# SPDX-License-Identifier: MIT
"""Until when a repeated value is valid. Times are s."""

from math import inf

LEAST_S, _FIRST_S, _MOST_S = 5.0, 30.0, 60.0
_INTERVALS = 2.5
_COPY_S = 0.5


class Validity:
    """Valid for 2.5 of the value's last interval, from `least_s` to 60 s; at first for 30 s.

    So one lost message of any rate invalidates nothing. A repetition within 0.5 s, such as a copy
    over another link, is no interval.
    """

    def __init__(self) -> None:
        self.heard_s = -inf
        self.until_s = -inf

    def renew(self, now_s: float, least_s: float = LEAST_S) -> None:
        """The value has arrived."""
        interval_s = now_s - self.heard_s
        if interval_s < _COPY_S:
            return
        span_s = _FIRST_S if interval_s == inf else min(_INTERVALS * interval_s, _MOST_S)
        self.heard_s, self.until_s = now_s, now_s + max(least_s, span_s)
