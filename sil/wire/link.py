# SPDX-License-Identifier: MIT
"""A one-way link that carries chunks (datagrams): delay, jitter, loss, bandwidth."""

from heapq import heappop, heappush
from typing import Protocol


class Rng(Protocol):
    """random.Random or numpy.random.Generator, seeded by the caller."""

    def random(self) -> float:
        """Uniform in [0, 1)."""


class Link:
    """Chunks arrive whole after serialisation, `delay_s` and a uniform jitter in [0, `jitter_s`).

    Jitter may change the order. A chunk is lost with probability `loss`, but still takes its time
    on the air. `rate_Bps` is bytes per second, 0 unlimited. These four may change while chunks are
    in flight. `rng` is used only if `loss` or `jitter_s` is not 0; a lost chunk draws no jitter.
    All times are in us, from one clock.
    """

    def __init__(
        self,
        rng: Rng,
        *,
        delay_s: float = 0.0,
        jitter_s: float = 0.0,
        loss: float = 0.0,
        rate_Bps: float = 0.0,
    ) -> None:
        self.delay_s = delay_s
        self.jitter_s = jitter_s
        self.loss = loss
        self.rate_Bps = rate_Bps
        self._rng = rng
        self._free_us = 0
        self._sent = 0
        self._arrived: list[bytes] = []
        self._in_flight: list[tuple[int, int, bytes]] = []

    def send(self, data: bytes, now_us: int) -> None:
        """Puts a chunk on the link at `now_us`."""
        if not (self._in_flight or self.delay_s or self.jitter_s or self.loss or self.rate_Bps):
            self._arrived.append(data)
            return
        arrival_us = now_us
        if self.rate_Bps:
            self._free_us = max(self._free_us, now_us) + round(1e6 * len(data) / self.rate_Bps)
            arrival_us = self._free_us
        if self.loss and self._rng.random() < self.loss:
            return
        latency_s = self.delay_s
        if self.jitter_s:
            latency_s += self.jitter_s * self._rng.random()
        arrival_us += round(1e6 * latency_s)
        self._sent += 1
        heappush(self._in_flight, (arrival_us, self._sent, data))

    def receive(self, now_us: int) -> list[bytes]:
        """The chunks that have arrived by `now_us` since the last call, in order of arrival."""
        arrived, self._arrived = self._arrived, []
        in_flight = self._in_flight
        while in_flight and in_flight[0][0] <= now_us:
            arrived.append(heappop(in_flight)[2])
        return arrived
