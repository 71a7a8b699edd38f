# SPDX-License-Identifier: MIT
"""Replays a recording: equal bytes and frames at equal times must give equal output."""

import struct
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Any

import flotilla

from sil.lockstep.recording import (
    BUS,
    CAN_IN,
    CAN_OUT,
    CLOCK,
    HOST,
    MAVLINK_OUT,
    RESTART,
    Recording,
)
from sil.wire.clock import Clock

Said = list[tuple[int, bytes]]

_HOST_EVENT = struct.Struct("<Bq")


class _Twin:
    """A boat built like the recorded one, fed with its recorded input; `settings`: see ticks()."""

    def __init__(
        self, header: Mapping[str, Any], settings: Callable[[Any], None] = lambda _: None
    ) -> None:
        self._links, self._scalar = header["links"], header["scalar"]
        self._settings = settings
        self._boat = self._boot(header["parameters"])
        self._clock = Clock(**header["clock"])
        self._recorded: Said = []
        self.ticked_us = -1

    def _boot(self, parameters: dict[str, float]) -> Any:
        boat = flotilla.Boat(parameters, self._links, self._scalar)
        self._settings(boat)
        return boat

    def _take_host(self, event: int, value: int) -> None:
        if event == BUS:
            self._boat.on_host(bus_up=bool(value))
        elif event == CLOCK:
            self._clock = replace(self._clock, offset_us=value)
        elif event == RESTART:
            self._boat = self._boot(self._boat.parameters())

    def take(self, t_us: int, channel: int, data: bytes) -> None:
        if channel >= HOST:
            self._take_host(*_HOST_EVENT.unpack(data))
        elif channel >= MAVLINK_OUT:
            self._recorded.append((channel, data))
            self.ticked_us = t_us
        elif channel >= CAN_IN:
            can_id = int.from_bytes(data[:4], "little")
            self._boat.on_can(can_id, data[4:], self._clock.at(t_us))
        else:
            self._boat.on_mavlink(data, self._clock.at(t_us), channel)

    def tick(self) -> Any:
        """Tick the twin at the recorded boat's last tick; its output."""
        return self._boat.tick(self._clock.at(self.ticked_us))

    def differs(self) -> bool:
        """Tick the twin at the recorded boat's last tick, if any; whether the outputs differ."""
        if not self._recorded:
            return False
        out = self.tick()
        said = [(CAN_OUT, i.to_bytes(4, "little") + d) for i, d in out.can]
        said += [(MAVLINK_OUT + link, data) for link, data in out.mavlink]
        recorded, self._recorded = self._recorded, []
        return said != recorded


def replay(recording: Recording) -> list[int]:
    """For each boat, the world's time in us of the first tick that differs, or -1."""

    def compare(boat: int) -> None:
        if twins[boat].differs() and first[boat] < 0:
            first[boat] = twins[boat].ticked_us

    twins = [_Twin(header) for header in recording.header["boats"]]
    first = [-1] * len(twins)
    for t_us, port, data in recording:
        boat, channel = (port >> 8) - 1, port & 0xFF
        if boat < 0:  # the virtual leader
            continue
        # The output records of a tick are contiguous; the boat's next input or tick ends them.
        answers = MAVLINK_OUT <= channel < HOST
        if not answers or t_us != twins[boat].ticked_us:
            compare(boat)
        twins[boat].take(t_us, channel, data)
    for boat in range(len(twins)):
        compare(boat)
    return first


def ticks(
    recording: Recording,
    number: int,
    header: Mapping[str, Any],
    settings: Callable[[Any], None] = lambda _: None,
) -> Iterator[tuple[int, Any]]:
    """Feed boat `number`'s recorded input to a boat with another header; yield time and output.

    The world's time is in us. `settings` is applied to the boat whenever it starts: it sets what a
    header does not have, such as a link's limit.
    """
    twin = _Twin(header, settings)
    for t_us, port, data in recording:
        channel = port & 0xFF
        if port >> 8 != number:
            continue
        if not MAVLINK_OUT <= channel < HOST:
            twin.take(t_us, channel, data)
        elif t_us != twin.ticked_us:
            twin.ticked_us = t_us
            yield t_us, twin.tick()
