# SPDX-License-Identifier: MIT
"""A live view: turns messages heard at an address into frames for the page."""

import time
from collections import deque
from collections.abc import Iterable
from typing import Any

from sil.view import alarm
from sil.view.hear import Listener
from sil.view.plain_json import json_of
from sil.view.seen_fleet import Fleet
from sil.view.tlog_history import Watch
from sil.wire.mavlink_ear import Message

FRAMES_PER_S = 10
_WINDOW_S = 1.0
_NEWS_EVERY = 10  # frames


class Live:
    """Listens at `address` while `run` runs; `length_m`: of the boats. Raises as `Listener`."""

    def __init__(self, address: str, length_m: float) -> None:
        self._listener = Listener(address)
        self._fleet = Fleet(length_m)
        self._watch = Watch(self._fleet)
        self._began_s = time.monotonic()
        self._frames = 0
        self._news: tuple[dict[int, Any], int] = {}, 0
        self._bytes, self._heard_s = 0, 0.0
        self._heard: deque[tuple[float, int]] = deque([(0.0, 0)])

    async def run(self) -> None:
        """Listen until cancelled."""
        await self._listener.run(self._take)

    def _take(self, heard: Iterable[Message]) -> None:
        now_s = self._now_s()
        for message in heard:
            self._watch.hear(now_s, message)

    def _now_s(self) -> float:
        return time.monotonic() - self._began_s

    def look(self) -> None:
        """Keep the current view for a replay; call once per frame."""
        self._watch.wait(self._now_s())

    def history(self) -> dict[str, Any]:
        """The history since the beginning, for a replay."""
        return self._watch.history(f"Replay of the messages heard at {self._listener.address}")

    def frame(self) -> dict[str, Any]:
        """The current frame for the page."""
        now_s = self._now_s()
        vessels = self._fleet.vessels(now_s)
        plans = self._fleet.drawn_plans()
        ear = self._listener.ear
        # Plans and texts are long and seldom change; a page just opened gets them a little later.
        self._frames += 1
        texts_heard = self._fleet.texts_heard
        is_news = plans is not self._news[0] or texts_heard != self._news[1]
        self._news = plans, texts_heard
        is_sent = is_news or self._frames % _NEWS_EVERY == 0
        return {
            **({"plans": plans, "texts": self._fleet.texts()} if is_sent else {}),
            "t_s": round(now_s, 3),
            "origin_deg": self._fleet.origin_deg,
            "table": self._fleet.table.line(now_s),
            "heard": {
                "address": self._listener.address,
                "alarm": self._alarm(now_s),
                "bytes_per_s": self._bytes_per_s(now_s, ear.heard),
                "damaged": ear.damaged,
                "ignored": self._fleet.ignored,
                "vessels": len(vessels),
            },
            "vessels": vessels,
        }

    def text(self) -> str:
        """The frame as JSON."""
        return json_of(self.frame())

    def _alarm(self, now_s: float) -> str | None:
        """The reason why nothing is heard, and its remedy; None if all is well."""
        if self._listener.trouble is not None:
            return f"{self._listener.address}: {self._listener.trouble}"
        if self._listener.ear.heard != self._bytes:
            self._bytes, self._heard_s = self._listener.ear.heard, now_s
        return alarm.of_silence(self._listener.address, now_s - self._heard_s)

    def _bytes_per_s(self, now_s: float, heard: int) -> int:
        """Bytes per second over the last second, or since the last frame if that is longer ago."""
        while len(self._heard) > 1 and now_s - self._heard[1][0] >= _WINDOW_S:
            self._heard.popleft()
        since_s, before = self._heard[0]
        self._heard.append((now_s, heard))
        return round((heard - before) / max(now_s - since_s, 0.1))
