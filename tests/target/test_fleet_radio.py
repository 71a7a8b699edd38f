# SPDX-License-Identifier: MIT
"""Radio links of a fleet: late, lossy, slow, with changing quality, damaged."""

from __future__ import annotations

import random
from typing import Any

import flotilla
import numpy as np
import pytest
from fastcrc import crc16
from pymavlink.dialects.v20 import common as mavlink

from tests.target.reference_fleet import SplitMix64
from tests.target.twin_fleets import EXACT, LOCAL, Twins

RADIOS = [
    {"delay_s": 0.035},
    {"loss": 0.4},
    {"delay_s": 0.02, "jitter_s": 0.08},
    {"rate_Bps": 5000.0},
    {"delay_s": 0.1, "jitter_s": 0.05, "loss": 0.3, "rate_Bps": 20_000.0},
    {"loss": 1.0},
    {"delay_s": 0.0200005},  # half a microsecond after a tick rounds to the tick
]


@pytest.mark.parametrize("radio", RADIOS)
def test_a_diamond_with_a_bad_radio_sails_as_its_boats_do_one_by_one(
    radio: dict[str, Any],
) -> None:
    twins = Twins()
    twins.diamond(**radio)
    twins.enter_formation()
    twins.tick(600)
    assert len(twins.compare()) > 100_000


def test_links_that_change_while_chunks_are_in_flight_deliver_as_single_ones_do() -> None:
    twins = Twins()
    links = twins.diamond()
    twins.enter_formation()
    rng = random.Random(1)
    for _ in range(40):
        radio = rng.choice([{}, *RADIOS])
        names = ("delay_s", "jitter_s", "loss", "rate_Bps")
        twins.both("set_link", rng.choice(links), *(radio.get(name, 0.0) for name in names))
        twins.tick(rng.randrange(1, 30))
    twins.compare()


def test_numbers_of_a_link_are_those_of_splitmix64() -> None:
    """First outputs of the reference implementation in C for seed 1234567."""
    rng = SplitMix64(1234567)
    expected = [6457827717110365317, 3203168211198807973, 9817491932198370423]
    assert [rng.random() for _ in expected] == [(x >> 11) * 2.0**-53 for x in expected]


def test_a_links_losses_depend_only_on_its_seed() -> None:
    def sail(seed: int) -> bytes:
        fleet = flotilla.Fleet(record=True)
        boats = [fleet.add_boat(0, {"MAV_SYSID": 1 + i}, LOCAL, EXACT) for i in range(2)]
        fleet.connect(*boats, loss=0.5, seed=seed)
        still, shafts = np.zeros((2, 3)), np.zeros((2, 2))
        for k in range(100):
            fleet.tick(10_000 * k, still, still, None, shafts, np.empty((2, 2)))
        return bytes(fleet.take_records(0))

    assert sail(3) == sail(3) != sail(2**64 - 1)


def test_a_flipped_bit_has_the_same_effect_in_a_fleet_as_on_one_boat() -> None:
    twins = Twins()
    links = twins.diamond()
    twins.tick(100)
    before = twins.both("snapshot", 1)["counters"]
    twins.both("corrupt", links[0], 8 * 12 + 3)
    twins.tick(2)
    after = twins.both("snapshot", 1)["counters"]
    assert after["mavlink_bad_checksum"] == before["mavlink_bad_checksum"] + 1
    twins.tick(100)
    assert (
        twins.both("snapshot", 1)["counters"]["mavlink_bad_checksum"]
        == (after["mavlink_bad_checksum"])
    )
    twins.compare()


@pytest.mark.parametrize("radio", [{}, {"delay_s": 0.02}])
def test_flipped_bits_have_the_same_effect_in_a_fleet_as_on_single_boats(
    radio: dict[str, Any],
) -> None:
    """Leaders too must find the requests among the damage."""
    twins = Twins()
    links = twins.diamond(**radio)
    rng = random.Random(2)
    for _ in range(600):
        twins.both("corrupt", rng.choice(links), rng.randrange(1 << 15))
        twins.tick()
    for boat in twins.boats:
        assert twins.both("snapshot", boat)["counters"]["mavlink_bad_checksum"] > 20
    twins.compare()


def timesync(sequence: int, target: bytes, tc1: int = 0) -> bytes:
    """A TIMESYNC request or answer of a ground station; `target`: to one system only."""
    payload = tc1.to_bytes(8, "little") + (1000 + sequence).to_bytes(8, "little") + target
    body = bytes((len(payload), 0, 0, sequence, 255, 190, 111, 0, 0)) + payload
    return b"\xfd" + body + crc16.mcrf4xx(body + b"\x22").to_bytes(2, "little")


def behind_a_boat() -> tuple[Twins, list[int], int]:
    """Two leaders that hear a boat, which forwards messages for them from link 0 to its radio."""
    twins = Twins()
    leaders = [twins.leader(system=100), twins.leader(system=101)]
    boat = twins.boat({"MAV_SYSID": 4, "FORM_LEADER": 100})
    links = [twins.tie(leader, boat)[1] for leader in leaders]
    twins.tick(150)
    return twins, links, boat


def answers(twins: Twins) -> int:
    """The number of leaders' answers to request 1."""
    told = []
    for _ in range(3):
        twins.tick()
        told += [twins.both("sent", leader).count(b"\xe9\x03") for leader in twins.leaders]
    twins.compare()
    return sum(told)


@pytest.mark.parametrize("target", [b"\x64", b"\x64\x01", b"\x64\x02", b"\x65\x01"])
def test_leaders_answer_only_requests_addressed_to_them(target: bytes) -> None:
    twins, _, boat = behind_a_boat()
    twins.both("hear", boat, timesync(1, target) + timesync(2, target, tc1=5), twins.t_us, 0)
    assert answers(twins) == (target != b"\x64\x02")


@pytest.mark.parametrize("damaged", [False, True])
def test_a_request_inside_another_message_is_found_behind_garbage_only(damaged: bool) -> None:
    twins, links, boat = behind_a_boat()
    content = timesync(1, b"").ljust(251, b"\0")
    message = mavlink.MAVLink_file_transfer_protocol_message(0, 100, 1, content)
    chunk = timesync(2, b"\x64") + message.pack(mavlink.MAVLink(None, 255, 190))
    twins.both("hear", boat, chunk, twins.t_us, 0)
    if damaged:
        twins.both("corrupt", links[0], 0)
    assert answers(twins) == damaged
