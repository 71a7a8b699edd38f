# SPDX-License-Identifier: MIT
"""A live view: what is heard at an address, as frames for the page."""

import json
import time
from collections import deque
from collections.abc import Iterable
from typing import Any

from sil.view.hear import Listener
from sil.view.seen_fleet import Fleet
from sil.wire.mavlink_ear import Message

FRAMES_PER_S = 10
_WINDOW_S = 1.0


class Live:
    """Listens at `address` from `run` on; `length_m`: of boats. Raises as `Listener`."""

    def __init__(self, address: str, length_m: float) -> None:
        self._listener = Listener(address)
        self._fleet = Fleet(length_m)
        self._began_s = time.monotonic()
        self._heard: deque[tuple[float, int]] = deque([(0.0, 0)])

    async def run(self) -> None:
        """Listens until it is cancelled."""
        await self._listener.run(self._take)

    def _take(self, heard: Iterable[Message]) -> None:
        self._fleet.hear(heard, time.monotonic() - self._began_s)

    def frame(self) -> dict[str, Any]:
        """What there is to show now."""
        now_s = time.monotonic() - self._began_s
        vessels = self._fleet.vessels(now_s)
        ear = self._listener.ear
        return {
            "t_s": round(now_s, 3),
            "heard": {
                "address": self._listener.address,
                "bytes_per_s": self._bytes_per_s(now_s, ear.heard),
                "damaged": ear.damaged,
                "ignored": self._fleet.ignored,
                "vessels": len(vessels),
            },
            "vessels": vessels,
        }

    def text(self) -> str:
        """The frame as JSON."""
        return json.dumps(self.frame(), separators=(",", ":"), allow_nan=False)

    def _bytes_per_s(self, now_s: float, heard: int) -> int:
        """Of the last second, or since the last frame where that was longer ago."""
        while len(self._heard) > 1 and now_s - self._heard[1][0] >= _WINDOW_S:
            self._heard.popleft()
        since_s, before = self._heard[0]
        self._heard.append((now_s, heard))
        return round((heard - before) / max(now_s - since_s, 0.1))
