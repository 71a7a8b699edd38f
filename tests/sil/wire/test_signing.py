# SPDX-License-Identifier: MIT
"""Signatures against pymavlink's, both ways; keys as flotillad reads them."""

import time
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as mavlink

from sil.wire.signing import Signer, is_signed, numbered, read_key

KEY = bytes(range(7, 39))
EPOCH_S, PER_S = 1_420_070_400, 100_000


def pymavlink(key: bytes = KEY, late_s: float = 0.0, link: int = 3) -> mavlink.MAVLink:
    mav = mavlink.MAVLink(None, 9, 190)
    mav.signing.secret_key, mav.signing.link_id = key, link
    mav.signing.timestamp = round((time.time() - EPOCH_S - late_s) * PER_S)
    mav.signing.sign_outgoing = True
    return mav


def beat(mav: mavlink.MAVLink) -> bytes:
    frame: bytes = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(mav)
    return frame


def unsigned() -> bytes:
    return beat(mavlink.MAVLink(None, 255, 25))


def test_pymavlink_accepts_our_signatures_and_no_others() -> None:
    ours, theirs = Signer(KEY, 70), pymavlink()
    for sequence in (0, 200):
        frame = ours.sign(numbered(unsigned(), sequence))
        assert is_signed(frame) and not is_signed(unsigned())
        (message,) = theirs.parse_buffer(frame)
        assert message.get_type() == "HEARTBEAT" and message.get_signed()
        assert (message.get_seq(), message.get_srcComponent()) == (sequence, 25)
    stranger = Signer(bytes(32), 70).sign(unsigned())
    with pytest.raises(mavlink.MAVError, match="signature"):
        theirs.parse_buffer(stranger)


def test_a_message_signed_by_pymavlink_is_accepted_once() -> None:
    ours = Signer(KEY, 70)
    frame = beat(pymavlink())
    assert ours.verifies(frame)
    assert not ours.verifies(frame)  # a replay
    assert not ours.verifies(unsigned())
    assert not ours.verifies(beat(pymavlink(bytes(32))))


@pytest.mark.parametrize("at", [3, 12, 20, -14, -8, -1])
def test_a_changed_byte_makes_the_signature_false(at: int) -> None:
    frame = bytearray(beat(pymavlink()))
    frame[at] ^= 1
    assert not Signer(KEY, 70).verifies(bytes(frame))


def test_a_message_older_than_a_minute_is_not_taken() -> None:
    assert Signer(KEY, 70).verifies(beat(pymavlink(late_s=50.0)))
    assert not Signer(KEY, 70).verifies(beat(pymavlink(late_s=70.0)))


def test_an_old_message_with_the_key_has_an_age_and_one_with_another_key_has_none() -> None:
    ours = Signer(KEY, 70)
    assert ours.late_s(beat(pymavlink(late_s=120.0))) == pytest.approx(120.0, abs=5.0)
    assert ours.late_s(beat(pymavlink(late_s=50.0))) is None
    assert ours.late_s(beat(pymavlink(bytes(32), late_s=120.0))) is None
    assert ours.late_s(unsigned()) is None


def test_each_sender_and_link_has_its_own_time() -> None:
    ours = Signer(KEY, 70)
    assert ours.verifies(beat(pymavlink(link=1)))
    assert ours.verifies(beat(pymavlink(link=2, late_s=30.0)))
    assert not ours.verifies(beat(pymavlink(link=1, late_s=30.0)))


def test_two_signatures_never_have_one_time() -> None:
    ours = Signer(KEY, 70)
    times = [int.from_bytes(ours.sign(unsigned())[-12:-6], "little") for _ in range(100)]
    assert times == sorted(set(times))


@pytest.mark.parametrize("content", [KEY, KEY.hex().encode(), KEY.hex().encode() + b"\n"])
def test_a_key_is_bytes_or_digits(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "key"
    file.write_bytes(content)
    file.chmod(0o600)
    assert read_key(file) == KEY


@pytest.mark.parametrize(
    ("content", "mode", "said"),
    [
        (KEY, 0o640, "mode 0640 lets others use the key"),
        (KEY[:-1], 0o600, "a key is 32 bytes"),
        (b"", 0o600, "a key is 32 bytes"),
        (KEY.hex().encode()[:-2], 0o600, "64 hexadecimal digits"),
        (b"x" * 64, 0o600, "64 hexadecimal digits"),
    ],
)
def test_a_bad_key_is_refused(tmp_path: Path, content: bytes, mode: int, said: str) -> None:
    file = tmp_path / "key"
    file.write_bytes(content)
    file.chmod(mode)
    with pytest.raises(ValueError, match=said):
        read_key(file)
