# SPDX-License-Identifier: MIT
"""A boat lists its host's logs over MAVLink and sends them whole over any link."""

from __future__ import annotations

import random
from collections.abc import Sequence
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.sea import Sea, texts
from tests.target.stations import BOAT, GCS, Station

PACKET, MOST = 90, 0xFFFFFFFF
ARDUPILOT = {"MAV_AUTOPILOT": 1.0}


def log(size: int, seed: int = 1) -> bytes:
    return random.Random(seed).randbytes(size)


class Reader:
    """A client that asks for what is missing until it has a whole log."""

    def __init__(self, sea: Sea, loss: float = 0.0, seed: int = 5) -> None:
        self.sea = sea
        self._dice = random.Random(seed)
        self._loss = loss

    def say(self, message: Any) -> None:
        if self._dice.random() >= self._loss:
            self.sea.say(message)

    def hear(self, name: str, seconds: float) -> list[Any]:
        heard = [m for tick in self.sea.run(seconds) for m in tick.named(name)]
        return [m for m in heard if self._dice.random() >= self._loss]

    def entries(self, start: int = 0, end: int = 0xFFFF) -> dict[int, Any]:
        self.say(mavlink.MAVLink_log_request_list_message(BOAT, 1, start, end))
        return {m.id: m for m in self.hear("LOG_ENTRY", 0.5)}

    def listed(self) -> dict[int, int]:
        """Sizes by id; asks again for what was lost."""
        got: dict[int, Any] = {}
        while not got or len(got) < next(iter(got.values())).num_logs:
            got |= self.entries()
        return {id_: got[id_].size for id_ in sorted(got)}

    def read(self, id_: int, size: int) -> bytes:
        parts: dict[int, bytes] = {}
        while missing := [at for at in range(0, size, PACKET) if at not in parts]:
            for first, end in runs(missing)[:20]:
                ask = mavlink.MAVLink_log_request_data_message(BOAT, 1, id_, first, end - first)
                self.say(ask)
            for m in self.hear("LOG_DATA", 1.0):
                assert m.id == id_ and m.ofs % PACKET == 0
                parts[m.ofs] = bytes(m.data[: m.count])
        return b"".join(parts[at] for at in sorted(parts))


def runs(missing: Sequence[int]) -> list[tuple[int, int]]:
    """Ranges of bytes without gaps."""
    out: list[tuple[int, int]] = []
    for at in missing:
        begins = not out or out[-1][1] != at
        out = [*out, (at, at + PACKET)] if begins else [*out[:-1], (out[-1][0], at + PACKET)]
    return out


def sea_with(logs: Sequence[bytes], parameters: dict[str, float] | None = None) -> Sea:
    sea = Sea(parameters)
    sea.boat.keep_logs(list(logs))
    sea.settle()
    return sea


@pytest.mark.parametrize("size", [1, 89, 90, 91, 180, 23_039, 23_040, 23_041, 70_001])
def test_a_log_of_any_length_comes_whole(size: int) -> None:
    sea = sea_with([log(7), log(size, 2)])
    reader = Reader(sea)
    assert reader.listed() == {0: 7, 1: size}
    assert reader.read(1, size) == log(size, 2)


def test_a_log_comes_whole_though_a_quarter_of_the_messages_are_lost() -> None:
    sea = sea_with([log(60_000), log(45_000, 2)])
    reader = Reader(sea, loss=0.25)
    assert reader.listed() == {0: 60_000, 1: 45_000}
    assert reader.read(0, 60_000) == log(60_000)
    assert reader.read(1, 45_000) == log(45_000, 2)


def test_ardupilots_ids_begin_with_1_after_an_empty_log() -> None:
    sea = sea_with([log(100), log(200, 2)], ARDUPILOT)
    reader = Reader(sea)
    assert reader.listed() == {0: 0, 1: 100, 2: 200}
    assert reader.read(2, 200) == log(200, 2)
    (last,) = reader.entries(2, 2).values()
    assert (last.num_logs, last.last_log_num) == (3, 2)


def test_only_the_newest_are_listed_where_there_are_too_many() -> None:
    logs = [bytes([k % 256]) * (k + 1) for k in range(300)]
    reader = Reader(sea_with(logs))
    listed = reader.listed()
    assert listed == {k: 51 + k for k in range(250)}
    assert reader.read(249, 300) == logs[-1]


@pytest.mark.parametrize("open_", [False, True])
def test_without_logs_the_list_is_empty(open_: bool) -> None:
    sea = sea_with([]) if open_ else Sea()
    sea.settle()
    (only,) = Reader(sea).entries().values()
    assert (only.id, only.num_logs, only.size) == (0, 0, 0)
    sea.say(mavlink.MAVLink_log_request_data_message(BOAT, 1, 0, 0, MOST))
    ticks = sea.run(0.5)
    assert not [m for tick in ticks for m in tick.named("LOG_DATA")]
    assert any(text.startswith("Refused: no ") for text in texts(ticks))


def test_a_read_beyond_the_end_of_a_log_returns_the_end() -> None:
    sea = sea_with([log(180)])
    reader = Reader(sea)
    reader.listed()
    for offset in (180, 181, MOST):
        reader.say(mavlink.MAVLink_log_request_data_message(BOAT, 1, 0, offset, MOST))
        (end,) = reader.hear("LOG_DATA", 0.3)
        assert (end.ofs, end.count) == (180, 0)


def test_a_client_can_end_its_transfer_of_a_log() -> None:
    sea = sea_with([log(500_000)])
    reader = Reader(sea)
    reader.listed()
    reader.say(mavlink.MAVLink_log_request_data_message(BOAT, 1, 0, 0, MOST))
    assert len(reader.hear("LOG_DATA", 0.5)) > 100
    reader.say(mavlink.MAVLink_log_request_end_message(BOAT, 1))
    reader.hear("LOG_DATA", 0.1)
    assert not reader.hear("LOG_DATA", 0.5)


def test_logs_are_not_erased_from_afar() -> None:
    sea = sea_with([log(100)])
    reader = Reader(sea)
    reader.say(mavlink.MAVLink_log_erase_message(BOAT, 1))
    assert "Refused: logs cannot be erased remotely" in texts(sea.run(0.2))
    assert reader.listed() == {0: 100}


def test_sending_a_log_does_not_slow_the_telemetry_of_the_state() -> None:
    sea = sea_with([log(500_000)])
    sea.boat.limit_link(0, 4000)
    reader = Reader(sea)
    reader.listed()
    reader.say(mavlink.MAVLink_log_request_data_message(BOAT, 1, 0, 0, MOST))
    ticks = sea.run(5.0)
    states = [m for tick in ticks for m in tick.named("ATTITUDE")]
    assert len(states) >= 48 and [m for tick in ticks for m in tick.named("LOG_DATA")]


def test_a_station_that_may_not_command_may_still_list_the_logs() -> None:
    sea = sea_with([log(100)], {"MAV_GCS_SYSID": GCS})
    sea.say(mavlink.MAVLink_log_request_list_message(BOAT, 1, 0, 0xFFFF), sender=Station(9, 190))
    assert [m for tick in sea.run(0.3) for m in tick.named("LOG_ENTRY")]
