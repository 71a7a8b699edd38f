# SPDX-License-Identifier: MIT
"""flotillad with a key: only its holders are obeyed, and the signing time never goes back."""

import signal
import time
import zlib
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as mavlink

from sil.live.free_port import free_port
from tests.linux.config.test_config import mistake
from tests.linux.process import LOOPBACK, RealSea, Udp
from tests.target.stations import Station, command_long

KEY = bytes(range(7, 39))
EPOCH_S, SECOND = 1_420_070_400, 100_000
UNKNOWN = 999  # a command that every boat answers


def clock() -> int:
    return round((time.time() - EPOCH_S) * SECOND)


def secure(parser: mavlink.MAVLink, key: bytes) -> None:
    parser.signing.secret_key, parser.signing.timestamp = key, clock()
    parser.signing.sign_outgoing = True


@pytest.fixture
def key(tmp_path: Path) -> Path:
    file = tmp_path / "key"
    file.write_bytes(KEY)
    file.chmod(0o600)
    return file


@pytest.fixture
def stamp_file(sea: RealSea) -> Path:
    return sea.state_dir / "signing_time.txt"


def stamp(file: Path) -> int:
    return int(file.read_text().split()[2])


def write(file: Path, timestamp: int) -> None:
    """Write a time stamp file, with another implementation of the checksum."""
    body = f"flotilla-signing-time 1 {timestamp}\n"
    file.write_text(body + f"crc32 = {zlib.crc32(body.encode()):08X}\n")


def required_link() -> Udp:
    end = Udp()
    end.option += ",signing=required"
    return end


def start(sea: RealSea, key: Path, *options: str) -> None:
    """Start with an operator's link that requires signatures; pymavlink verifies its messages."""
    if len(sea.ends) == 1:
        sea.connect(Udp(), required_link())
    sea.leader.on = False
    sea.start(f"--signing-key={key}", *options)
    secure(sea._parsers[-1], KEY)


def test_strangers_without_the_key_are_sent_nothing(sea: RealSea, key: Path) -> None:
    port = free_port()
    operator = Udp(port)
    operator.option += ",signing=required"
    stranger = Udp(port)
    sea.connect(Udp(), operator)
    secure(sea.gcs.encoder, KEY)
    sea.leader.on = False
    sea.start(f"--signing-key={key}")
    secure(sea._parsers[-1], KEY)
    sea.repeat(lambda: order(sea), sea.acks)
    for _ in range(10):
        stranger.send(Station(77, 1).pack(command_long(UNKNOWN)))
        sea.run(0.1)
    assert stranger.receive() == []
    stranger.close()


def order(sea: RealSea) -> None:
    sea.say(command_long(UNKNOWN))


def obeys_the_key(sea: RealSea) -> None:
    """Assert that a signed command is answered; pymavlink verifies the answer's signature."""
    heard = len(sea.acks())
    secure(sea.gcs.encoder, KEY)
    sea.repeat(lambda: order(sea), lambda: len(sea.acks()) > heard)
    assert all(m.get_signed() for m in sea.named("COMMAND_ACK"))
    assert not sea.named("BAD_DATA")


def test_a_link_that_requires_signatures_obeys_the_key_and_nobody_else(
    sea: RealSea, key: Path
) -> None:
    start(sea, key)
    obeys_the_key(sea)
    unsigned, stranger = Station(255, 190), Station(255, 190)
    secure(stranger.encoder, bytes(32))
    for number, other in ((UNKNOWN - 1, unsigned), (UNKNOWN - 2, stranger)):
        sea.ends[-1].send(other.pack(command_long(number)))
    obeys_the_key(sea)  # what was sent before has been read
    assert sea.end() == 0
    assert {command for command, _ in sea.acks()} == {UNKNOWN}


def test_hexadecimal_digits_are_a_key_too(sea: RealSea, key: Path) -> None:
    key.write_text(KEY.hex() + "\n")
    start(sea, key)
    obeys_the_key(sea)


def test_a_key_that_others_may_read_is_refused(bus: int, tmp_path: Path, key: Path) -> None:
    key.chmod(0o644)
    said = mistake(
        f"--can=mcast:{bus}",
        f"--mavlink=udpout:{LOOPBACK}:14550",
        f"--state-dir={tmp_path}",
        f"--signing-key={key}",
    )
    assert f"signing-key {key} has mode 0644: others can access the key (allowed: nothing" in said
    assert not (tmp_path / "signing_time.txt").exists()


def test_the_signing_time_is_stored_at_once_and_at_the_end(
    sea: RealSea, key: Path, stamp_file: Path
) -> None:
    before = clock()
    start(sea, key)
    sea.until(stamp_file.exists)
    assert before <= stamp(stamp_file) <= clock()
    before = clock()
    obeys_the_key(sea)
    assert sea.end() == 0
    assert before <= stamp(stamp_file) <= clock() + SECOND


@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGKILL])
def test_time_does_not_go_back_over_a_restart_even_where_the_clock_did(
    sea: RealSea, key: Path, stamp_file: Path, end: signal.Signals
) -> None:
    """As if the clock had been an hour ahead during the last voyage."""
    start(sea, key)
    sea.until(sea.ready)
    assert sea.end() == 0
    ahead = clock() + 3600 * SECOND
    write(stamp_file, ahead)
    start(sea, key)
    sea.until(lambda: sea.named("HEARTBEAT"))
    sent = [m.get_msgbuf()[-12:-6] for m in sea.named("HEARTBEAT")]
    assert all(int.from_bytes(each, "little") > ahead for each in sent)
    sea.until(lambda: "s behind signing_time.txt" in sea.process.words)
    sea.end(end)
    assert stamp(stamp_file) >= ahead


def test_a_damaged_stored_time_is_reported_and_the_clock_used(
    sea: RealSea, key: Path, stamp_file: Path
) -> None:
    start(sea, key)
    sea.until(stamp_file.exists)
    assert sea.end() == 0
    stamp_file.write_text(stamp_file.read_text().replace("1 ", "1 9", 1))
    start(sea, key)
    obeys_the_key(sea)
    sea.until(lambda: "signing_time.txt is damaged; not used" in sea.process.words)
    sea.end()
    assert stamp(stamp_file) < clock() + SECOND
