# SPDX-License-Identifier: MIT
"""Texts longer than a STATUSTEXT: sent in chunks that a ground station reassembles."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import flotilla
import pytest

from tests.target.operator_words import param_set
from tests.target.sea import Sea, Tick, named
from tests.target.stations import BOAT, STRANGER, Station, heartbeat

CHUNK = 50
LIST: list[dict[str, Any]] = flotilla.parameter_list()
DOUBLE = "another sender uses this boat's system and component id"


@dataclass
class Said:
    text: str
    severity: int
    id: int
    chunks: int


def sentences(ticks: list[Tick], link: int = 0) -> list[Said]:
    """Reassemble texts as QGroundControl does; fails on a violation of the protocol."""
    found: list[Said] = []
    parts: list[Any] = []
    for m in named(ticks, "STATUSTEXT", link):
        frame = bytes(m.get_msgbuf())
        raw = frame[10 : 10 + frame[1]].ljust(54, b"\0")[1 : 1 + CHUNK]  # with its NULs
        text, _, rest = raw.partition(b"\0")
        assert not rest.strip(b"\0"), "something behind the NUL"
        if m.id == 0:
            assert not parts and m.chunk_seq == 0 and text
            found.append(Said(text.decode("ascii"), m.severity, 0, 1))
            continue
        assert m.chunk_seq == len(parts)
        if parts:
            assert (m.id, m.severity) == (parts[0][0].id, parts[0][0].severity)
        parts.append((m, text))
        if len(text) < CHUNK:  # a NUL: the last one
            whole = b"".join(each for _, each in parts).decode("ascii")
            found.append(Said(whole, m.severity, m.id, len(parts)))
            parts = []
    assert not parts, "a sentence without an end"
    return found


def words(ticks: list[Tick]) -> list[str]:
    """The texts of the sentences on the first link."""
    return [said.text for said in sentences(ticks)]


def assert_well_cut(said: Said) -> None:
    """Only a text too long for one message is split, and a NUL marks its end."""
    if len(said.text) <= CHUNK:
        assert said.id == 0 and said.chunks == 1
    else:
        assert said.id != 0 and said.chunks == len(said.text) // CHUNK + 1


@pytest.mark.parametrize("links", [1, 3])
def test_a_long_sentence_comes_in_chunks_on_every_link(links: int) -> None:
    sea = Sea(links=links)
    double = Station(BOAT, 1)
    double.encoder.seq = 100
    sea.run(0.5)
    sea.say(heartbeat(), sender=double)
    ticks = sea.run(0.5)
    for link in range(links):
        (said,) = sentences(ticks, link)
        assert (said.text, said.severity, said.chunks) == (DOUBLE, 2, 2)
        assert_well_cut(said)


def test_all_chunks_of_a_sentence_are_in_one_tick_and_in_order(sea: Sea) -> None:
    sea.settle()
    sea.say(param_set("THR_DEAD", 999.0))
    ticks = [t for t in sea.run(0.5) if t.named("STATUSTEXT")]
    assert len(ticks) == 1
    (said,) = sentences(ticks)
    assert said.text.startswith("THR_DEAD 999 refused: ") and len(said.text) > CHUNK
    assert_well_cut(said)


def test_each_long_sentence_has_an_id_of_its_own(sea: Sea) -> None:
    sea.settle()
    seen = []
    for value in (21.0, 22.0, 23.0):
        sea.say(param_set("THR_DEAD", value))
        (said,) = sentences(sea.run(0.6))
        seen.append(said.id)
    assert len(set(seen)) == 3 and 0 not in seen


def test_short_sentences_have_no_id(sea: Sea) -> None:
    sea.leader.on = False
    sea.enter_hold()
    sea.mode(6)
    sea.own.on = False
    sea.disarm()
    sea.run(1.0)
    sea.arm()
    said = sentences(sea.ticks)
    assert len(said) == 7
    for each in said:
        assert each.id == 0
        assert_well_cut(each)


def test_texts_of_every_length_are_split_into_chunks_correctly() -> None:
    """Refusals of every parameter with ever longer numbers, also texts that fill a chunk."""
    sea = Sea()
    sea.settle()
    lengths = set()
    for p in LIST:
        if p["name"] == "MAV_IDENTITY":
            continue
        for value in (-2e5, -200000.5, -2000000.5, -123456789.0, -1.2345e-20, -1.234567e-20):
            if p["least"] <= value <= p["greatest"]:
                continue
            sea.say(param_set(p["name"], value))
            (said,) = sentences(sea.run(0.55))
            assert said.text.startswith(p["name"] + " -") and " refused: " in said.text
            assert str(p["greatest"])[:1] in said.text
            assert_well_cut(said)
            lengths.add(len(said.text))
    assert CHUNK in lengths and CHUNK + 1 in lengths and CHUNK - 1 in lengths


@pytest.mark.parametrize(
    ("name", "value"), [("MAV_IDENTITY", 1.0), ("THR_DEAD", 20.0), ("ESC_PORT", 1.0)]
)
def test_a_refusal_of_contradictory_parameters_is_sent_to_its_end(
    sea: Sea, name: str, value: float
) -> None:
    sea.settle()
    sea.say(param_set(name, value))
    (said,) = sentences(sea.run(0.5))
    assert_well_cut(said)
    end = {"MAV_IDENTITY": "191", "THR_DEAD": "THR_REV_MAX", "ESC_PORT": "same ESC"}[name]
    assert said.text.endswith(end)


def test_another_boats_words_are_not_repeated(sea: Sea) -> None:
    sea.settle()
    sea.say(heartbeat(), sender=Station(STRANGER, 1))
    assert not sentences(sea.run(2.0))
