# SPDX-License-Identifier: MIT
"""Ten minutes with a radio that damages every twentieth byte in both directions."""

from __future__ import annotations

import random
from collections import deque
from collections.abc import Iterator
from typing import Any

import pytest

from tests.dialect import dialect
from tests.target.course import TURN
from tests.target.hull import Afloat
from tests.target.operator_words import param_read, param_set
from tests.target.sea import Sea, assert_finite
from tests.target.stations import (
    FORMATION,
    GCS,
    GCS_COMPONENT,
    HOLD,
    REQUEST_MESSAGE,
    SET_MODE,
    Station,
    command_long,
    heartbeat,
)

MINUTES = 10
RATE_HZ = 50
SPOILT = 0.05  # of all bytes
NOISY = 1  # the link; the other one is clean
NAME = "LAW_KX"
VALUES = (0.125, 0.25, 0.5, 1.0)  # exact in a float: 1/s


def spoil(rng: random.Random, data: bytes) -> bytes:
    """Flip one bit of some bytes, replace others."""
    out = bytearray(data)
    for k in range(len(out)):
        if rng.random() < SPOILT:
            if rng.random() < 0.5:
                out[k] ^= 1 << rng.randrange(8)
            else:
                out[k] ^= rng.randrange(1, 256)
    return bytes(out)


class GroundStation:
    """Repeats its requests, and accepts the answers that arrive."""

    def __init__(self, rng: random.Random, modes: tuple[int, ...]) -> None:
        self.rng, self.modes = rng, modes
        self.station = Station(GCS, GCS_COMPONENT)
        self.parser = dialect().MAVLink(None)
        self.parser.robust_parsing = True
        self.wanted = 0  # index into VALUES
        self.confirmed = self.answered = 0
        self.sent_values = {0.0}
        #: Mode requests that the radio left intact, oldest first.
        self.intact: deque[int] = deque()

    def says(self, tick: int) -> Iterator[tuple[Any, int | None]]:
        """The messages of this tick; for a mode request, with the mode."""
        if tick % RATE_HZ == 0:
            yield heartbeat(6), None
        if tick % 20 == 3:
            value = VALUES[self.wanted]
            self.sent_values.add(value)
            yield param_set(NAME, value), None
        if tick % 25 == 7:
            names: list[int | str] = [NAME, "THR_FWD_MAX", 3, 17]
            yield param_read(self.rng.choice(names)), None
        if tick % 40 == 11:
            mode = self.modes[tick // 400 % len(self.modes)]
            yield command_long(SET_MODE, 1.0, float(mode)), mode
        if tick % 25 == 13:
            message = self.rng.choice([148.0, 242.0, 0.0, 1.0])
            yield command_long(REQUEST_MESSAGE, message), None

    def bytes_at(self, tick: int) -> bytes:
        wire = b""
        for message, mode in self.says(tick):
            frame = self.station.pack(message)
            spoilt = spoil(self.rng, frame)
            if mode is not None and spoilt == frame:
                self.intact.append(mode)
            wire += spoilt
        return wire

    def hear(self, data: bytes) -> None:
        for m in self.parser.parse_buffer(data) or []:
            if m.get_type() == "PARAM_VALUE" and m.param_id == NAME:
                if m.param_value == VALUES[self.wanted]:
                    self.confirmed += 1
                    self.wanted = (self.wanted + 1) % len(VALUES)
            elif m.get_type() == "COMMAND_ACK":
                self.answered += 1


def voyage(sea: Sea, gcs: GroundStation, garbage: bool) -> Iterator[Sea]:
    """Simulate ten minutes; yields after each tick."""
    for tick in range(MINUTES * 60 * RATE_HZ):
        wire = gcs.bytes_at(tick)
        if garbage and tick % 5 == 0:
            noise = gcs.rng.randbytes(gcs.rng.randrange(40))
            wire = noise + wire if gcs.rng.random() < 0.5 else wire + noise
        if wire:
            sea.boat.on_mavlink(wire, sea.now_us, NOISY)
        for link, data in sea.step().mavlink:
            if link == NOISY:
                gcs.hear(spoil(gcs.rng, data))
        yield sea
        sea.ticks.clear()


def afloat() -> Afloat:
    told = {"CTL_RATE": RATE_HZ, "SR_STATE": 2, NAME: 0.0}
    return Afloat(told, leader=TURN, links=2)


def assert_only_that_one_has_changed(sea: Sea, before: dict[str, float], sent: set[float]) -> None:
    now = sea.boat.parameters()
    assert now[NAME] in sent
    assert now == before | {NAME: now[NAME]}


@pytest.mark.parametrize("garbage", [False, True], ids=["spoilt", "spoilt and garbage"])
def test_a_disarmed_boat_stays_disarmed_and_as_it_was_set(garbage: bool) -> None:
    sea = afloat()
    gcs = GroundStation(random.Random(31 + garbage), modes=(HOLD,))
    before = sea.boat.parameters()
    for _ in voyage(sea, gcs, garbage):
        assert sea.state == "DISARMED" and not any(sea.commands)
        assert_only_that_one_has_changed(sea, before, gcs.sent_values)
    assert_noise_was_noise_and_words_came_through(sea, gcs)


@pytest.mark.parametrize("garbage", [False, True], ids=["spoilt", "spoilt and garbage"])
def test_a_boat_in_formation_changes_its_mode_only_on_request(garbage: bool) -> None:
    sea = afloat()
    sea.enter_formation()
    gcs = GroundStation(random.Random(41 + garbage), modes=(HOLD, FORMATION))
    before, state, changes = sea.boat.parameters(), "FORMATION", 0
    for _ in voyage(sea, gcs, garbage):
        if sea.state != state:
            state = sea.state
            changes += 1
            told = FORMATION if state == "FORMATION" else HOLD
            assert state in ("HOLD", "FORMATION")
            while gcs.intact and gcs.intact[0] != told:
                gcs.intact.popleft()
            assert gcs.intact, f"nobody has asked for {state}"
        assert_only_that_one_has_changed(sea, before, gcs.sent_values)
    assert changes > 10
    assert_noise_was_noise_and_words_came_through(sea, gcs)


def test_a_boat_in_formation_without_other_requests_stays_there() -> None:
    """The ground station only requests what is already so."""
    sea = afloat()
    sea.enter_formation()
    gcs = GroundStation(random.Random(51), modes=(FORMATION,))
    before = sea.boat.parameters()
    for _ in voyage(sea, gcs, garbage=True):
        assert sea.state == "FORMATION"
        assert_only_that_one_has_changed(sea, before, gcs.sent_values)
    assert_noise_was_noise_and_words_came_through(sea, gcs)


def assert_noise_was_noise_and_words_came_through(sea: Sea, gcs: GroundStation) -> None:
    assert sea.counter("mavlink_bad_checksum") > 1000
    assert gcs.confirmed > 20 and gcs.answered > 20
    assert sea.boat.parameters()[NAME] in VALUES
    assert_finite(sea.snapshot())
