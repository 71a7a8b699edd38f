# SPDX-License-Identifier: MIT
"""Holders of the key are obeyed, others are not, and cannot lock the holders out.

The signer and verifier is pymavlink, on link 1; the boat's own sea talks unsigned on link 0.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.dialect import dialect
from tests.target.sea import Sea, Tick, texts
from tests.target.stations import (
    ACCEPTED,
    ARM,
    BOAT,
    LEADER,
    NAVIGATION,
    UNSUPPORTED,
    Station,
    command_long,
    heartbeat,
)

KEY, OTHER_KEY = bytes(range(100, 132)), bytes(range(100, 131)) + b"\0"
NOW_S = 1_790_000_000
SECOND, DAY = 100_000, 86_400 * 100_000
NOW = (NOW_S - 1_420_070_400) * SECOND
COUNTERS = ("signed", "forged", "replayed", "future_stamp", "streams_full", "unsigned_refused")


def signer(key: bytes = KEY, at: int = NOW, link_id: int = 3, system: int = 255) -> Station:
    station = Station(system, 190)
    signing = station.encoder.signing
    signing.secret_key, signing.timestamp = key, at
    signing.link_id, signing.sign_outgoing = link_id, True
    return station


class SecureSea(Sea):
    """A sea whose link 1 has that policy; counters must not change unless a test expects it."""

    def __init__(self, policy: str, links: int = 2) -> None:
        super().__init__(links=links)
        self.boat.secure(KEY, NOW_S * 1_000_000)
        for link in range(1, links):
            self.boat.set_signing(link, policy)
        self.operator = signer()
        self.settle()

    def counts(self) -> dict[str, int]:
        return {name: self.counter(f"mavlink_{name}") for name in COUNTERS}

    def hear(self, wire: bytes, link: int = 1) -> Tick:
        self.boat.on_mavlink(wire, self.now_us, link)
        return self.step()

    def moved(self, wire: bytes, link: int = 1) -> tuple[bool, dict[str, int]]:
        """Send commands; whether the boat answers, and the counters that changed."""
        before = self.counts()
        answers = self.hear(wire, link).named("COMMAND_ACK", link)
        after = self.counts()
        return bool(answers), {k: after[k] - before[k] for k in after if after[k] != before[k]}

    def obeys_the_operator(self) -> bool:
        return self.moved(self.operator.pack(order())) == (True, {"signed": 1})


def order(command: int = 999) -> Any:
    """A command that every boat answers, if only with UNSUPPORTED."""
    return command_long(command)


def verified(chunk: bytes, key: bytes = KEY) -> list[Any]:
    """The boat's messages that pymavlink accepts with that key."""
    parser = dialect().MAVLink(None)
    parser.robust_parsing = True
    parser.signing.secret_key, parser.signing.timestamp = key, NOW
    found = parser.parse_buffer(chunk) or []
    return [m for m in found if m.get_type() != "BAD_DATA"]


@pytest.fixture(params=["accept", "required"])
def sea(request: pytest.FixtureRequest) -> SecureSea:
    return SecureSea(request.param)


def forged() -> bytes:
    return signer(OTHER_KEY).pack(order())


def forged_ahead() -> bytes:
    return signer(OTHER_KEY, at=NOW + 30 * SECOND).pack(order())


def changed() -> bytes:
    """A frame with another command, a corrected checksum and the old signature."""
    signed = bytearray(signer(at=NOW + 30 * SECOND).pack(order(998)))
    other = Station(255, 190).pack(order(999))
    body = bytearray(other[:-2])
    body[2] |= 1
    crc = mavlink.x25crc(body[1:])
    crc.accumulate([mavlink.MAVLink_command_long_message.crc_extra])
    return bytes(body) + crc.crc.to_bytes(2, "little") + bytes(signed[-13:])


def day_ahead() -> bytes:
    return signer(at=NOW + DAY).pack(order())


def day_ahead_from_somebody_else() -> bytes:
    return signer(at=NOW + DAY, system=66).pack(order())


def day_old_from_somebody_else() -> bytes:
    return signer(at=NOW - DAY, system=66).pack(order())


@pytest.mark.parametrize(
    ("attack", "counter"),
    [
        (forged, "forged"),
        (forged_ahead, "forged"),
        (changed, "forged"),
        (day_ahead, "future_stamp"),
        (day_ahead_from_somebody_else, "future_stamp"),
        (day_old_from_somebody_else, "replayed"),
    ],
)
@pytest.mark.parametrize("first", [True, False], ids=["first", "after the operator"])
def test_an_attack_is_counted_and_the_right_key_still_obeyed(
    sea: SecureSea, attack: Callable[[], bytes], counter: str, first: bool
) -> None:
    assert first or sea.obeys_the_operator()
    for _ in range(3):
        assert sea.moved(attack()) == (False, {counter: 1})
        assert sea.obeys_the_operator()


def test_a_replay_is_counted_on_every_link_and_the_right_key_still_obeyed() -> None:
    sea = SecureSea("required", links=3)
    recorded = [sea.operator.pack(order()) for _ in range(5)]
    for wire in recorded:
        assert sea.moved(wire) == (True, {"signed": 1})
    for wire in recorded:
        for link in (1, 2):
            assert sea.moved(wire, link) == (False, {"replayed": 1})
            assert sea.obeys_the_operator()


def test_an_armed_boat_cannot_be_disarmed_by_a_recording() -> None:
    sea = SecureSea("required")
    sea.hear(sea.operator.pack(command_long(ARM, 1.0)))
    disarm = sea.operator.pack(command_long(ARM, 0.0))
    arm = sea.operator.pack(command_long(ARM, 1.0))
    sea.hear(disarm)
    sea.hear(arm)
    sea.step()
    assert sea.state == "HOLD"
    sea.hear(disarm)
    sea.step()
    assert sea.state == "HOLD"


def test_the_answer_is_signed_and_pymavlink_verifies_it(sea: SecureSea) -> None:
    tick = sea.hear(sea.operator.pack(order()))
    sent = b"".join(data for link, data in tick.mavlink if link == 1)
    (answer,) = [m for m in verified(sent) if m.get_type() == "COMMAND_ACK"]
    assert (answer.result, answer.target_system) == (UNSUPPORTED, 255)
    assert answer.get_signed() and answer.get_link_id() == 1
    assert not verified(sent, OTHER_KEY)


def test_all_messages_of_a_boat_on_a_secure_link_can_be_verified(sea: SecureSea) -> None:
    ticks = sea.run(3.0)
    sent = b"".join(data for tick in ticks for link, data in tick.mavlink if link == 1)
    said = sum(len(tick.messages(1)) for tick in ticks)
    assert len(verified(sent)) == said > 60
    assert not any(m.get_signed() for tick in ticks for m in tick.messages(0))


def test_timestamps_rise_over_all_links_together() -> None:
    sea = SecureSea("accept", links=3)
    stamps = []
    for tick in sea.run(2.0):
        assert [link for link, _ in tick.mavlink] == sorted(link for link, _ in tick.mavlink)
        for link in (1, 2):
            stamps += [
                int.from_bytes(m.get_msgbuf()[-12:-6], "little") for m in tick.messages(link)
            ]
    assert len(stamps) > 80 and len(set(stamps)) == len(stamps)
    assert all(stamp > NOW for stamp in stamps)


def test_a_required_link_refuses_unsigned_messages_and_still_obeys_the_right_key() -> None:
    sea = SecureSea("required")
    for version1 in (False, True):
        unsigned = Station(255, 190).pack(order(), version1=version1)
        assert sea.moved(unsigned) == (False, {"unsigned_refused": 1})
        assert sea.obeys_the_operator()


def test_a_link_that_requires_signatures_accepts_a_radios_unsigned_status() -> None:
    sea = SecureSea("required")
    status = mavlink.MAVLink_radio_status_message(200, 200, 50, 10, 10, 0, 0)
    assert sea.moved(Station(51, 68).pack(status)) == (False, {})


def test_an_accepting_link_obeys_unsigned_messages() -> None:
    sea = SecureSea("accept")
    for version1 in (False, True):
        assert sea.moved(Station(255, 190).pack(order(), version1=version1)) == (True, {})
    assert sea.obeys_the_operator()


def test_a_link_without_signing_looks_at_no_signature_and_sends_none() -> None:
    sea = SecureSea("off")
    for station in (signer(), signer(OTHER_KEY), Station(255, 190)):
        tick_answers, moved = sea.moved(station.pack(order()))
        assert tick_answers and moved == {}
    assert not any(m.get_signed() for tick in sea.run(2.0) for m in tick.messages(1))


def test_each_link_keeps_to_its_own_policy() -> None:
    station = Station(255, 190)  # which counts its messages
    sea = SecureSea("required", links=3)
    sea.boat.set_signing(2, "accept")
    assert sea.moved(station.pack(order()), 2) == (True, {})
    assert sea.moved(station.pack(order()), 1) == (False, {"unsigned_refused": 1})
    assert sea.moved(station.pack(order()), 0) == (True, {})


def test_a_required_link_without_a_key_obeys_nobody() -> None:
    sea = Sea(links=2)
    sea.boat.set_signing(1, "required")
    for station in (signer(), signer(bytes(32), at=1), Station(255, 190)):
        sea.say(order(), sender=station, link=1)
        assert not sea.step().named("COMMAND_ACK", 1)
    assert sea.counter("mavlink_unsigned_refused") == 3


def test_the_limit_on_the_future_goes_on_with_the_hosts_clock(sea: SecureSea) -> None:
    late = signer(at=NOW + 90 * SECOND, system=66)
    assert sea.moved(late.pack(order())) == (False, {"future_stamp": 1})
    sea.boat.on_host(unix_us=(NOW_S + 31) * 1_000_000)
    assert sea.moved(late.pack(order())) == (True, {"signed": 1})
    sea.boat.on_host(unix_us=0)
    assert sea.moved(late.pack(order())) == (True, {"signed": 1})


def test_a_ground_station_cannot_advance_the_time_in_many_small_steps(sea: SecureSea) -> None:
    """In steps of 30 s, each of which is allowed."""
    ahead = signer(system=66)
    for step in range(1, 20):
        ahead.encoder.signing.timestamp = NOW + 30 * step * SECOND
        expected = (True, {"signed": 1}) if step < 3 else (False, {"future_stamp": 1})
        assert sea.moved(ahead.pack(order())) == expected
        assert sea.obeys_the_operator()


def test_a_secure_boat_sails(sea: SecureSea) -> None:
    tick = sea.hear(sea.operator.pack(command_long(ARM, 1.0, target=(BOAT, 1))))
    assert [m.result for m in tick.named("COMMAND_ACK", 1)] == [ACCEPTED]
    assert sea.state == "HOLD"


class Sailor(SecureSea):
    """A sea whose link 1 requires signatures, with a running host clock."""

    def __init__(self, **host: Any) -> None:
        self.host = host
        super().__init__("required")

    def step(self) -> Tick:
        self.boat.on_host(unix_us=NOW_S * 1_000_000 + self.now_us, **self.host)
        return super().step()

    def later(self, seconds: float) -> None:
        self.now_us += round(seconds * 1e6)
        self.settle()
        self.settle()

    def armed(self) -> bool:
        self.settle()
        self.hear(signer(at=self.stamp(), link_id=9).pack(command_long(ARM, 1.0)))
        self.step()
        return self.state == "HOLD"

    def stamp(self) -> int:
        return NOW + self.now_us // 10


def test_recordings_of_a_jammed_radio_are_refused_three_hours_later() -> None:
    sea = Sailor()
    sea.hear(sea.operator.pack(heartbeat()))
    sea.operator.encoder.signing.timestamp = sea.stamp()
    recorded = []
    for _ in range(10):  # they never arrive
        sea.operator.encoder.signing.timestamp += SECOND
        recorded.append(sea.operator.pack(command_long(ARM, 1.0)))
    sea.later(3 * 3600)
    for wire in recorded:
        assert sea.moved(wire) == (False, {"replayed": 1})
    assert sea.state == "DISARMED"


def test_a_pymavlink_that_hears_the_boat_is_obeyed_after_any_silence() -> None:
    """Its timestamps follow those it receives, and otherwise stand still."""
    sea = Sailor()
    sea.operator.encoder.signing.timestamp = sea.stamp()
    assert sea.obeys_the_operator()
    sea.later(3600)
    assert sea.moved(sea.operator.pack(order())) == (False, {"replayed": 1})
    hears = sea.operator.encoder
    for data in [data for tick in sea.ticks[-30:] for link, data in tick.mavlink if link == 1]:
        hears.parse_buffer(data)
    assert sea.obeys_the_operator()


def test_a_pymavlink_that_hears_nobody_is_obeyed_for_hours() -> None:
    sea = Sailor()
    sea.operator.encoder.signing.timestamp = sea.stamp()
    for _ in range(60):
        assert sea.obeys_the_operator()
        sea.later(55)


STOPS = {
    "disarm": (command_long(ARM, 0.0), "DISARMED"),
    "terminate": (command_long(185, 1.0), "FAULT"),
    "hold": (command_long(176, 1.0, 4.0), "HOLD"),
    "hold by SET_MODE": (mavlink.MAVLink_set_mode_message(BOAT, 1, 4), "HOLD"),
}


@pytest.mark.parametrize("late_s", [-7200, 7200])
@pytest.mark.parametrize("what", STOPS)
def test_a_stop_is_obeyed_at_any_timestamp_but_only_once(what: str, late_s: int) -> None:
    sea = Sailor()
    assert sea.armed()
    sea.hear(sea.operator.pack(command_long(176, 1.0, 6.0)))
    sea.operator.encoder.signing.timestamp = sea.stamp() + 1
    sea.hear(sea.operator.pack(command_long(176, 1.0, 6.0)))
    sea.step()
    assert sea.state == "FORMATION"
    message, state = STOPS[what]
    lost = signer(at=sea.stamp() - late_s * SECOND, link_id=17)
    stop = lost.pack(message)
    sea.hear(stop)
    sea.step()
    assert sea.state == state
    sea.hear(signer(at=sea.stamp(), link_id=18).pack(command_long(ARM, 0.0)))
    assert sea.armed()
    for again in (stop, signer(OTHER_KEY, at=sea.stamp() - SECOND * late_s + 9).pack(message)):
        sea.hear(sea.operator.pack(command_long(176, 1.0, 6.0)))
        sea.step()
        sea.hear(again)
        sea.step()
        assert sea.state == "FORMATION"


def system_time(unix_s: int) -> Any:
    return mavlink.MAVLink_system_time_message(unix_s * 1_000_000, 1000)


def tell_time(sea: Sailor, unix_s: int, sender: Station) -> None:
    """Three reports, a second apart: enough to be believed."""
    for second in range(3):
        sea.say(system_time(unix_s + second), sender=sender)
        sea.run(1.0)
    sea.settle()


UNIT = Station(BOAT, NAVIGATION)
YEAR = 365 * DAY


def test_without_a_clock_a_boat_obeys_and_learns_the_time_from_its_navigation_unit() -> None:
    """The host's clock is a year behind."""
    sea = Sailor(clock_is_set=False)
    ahead = signer(at=NOW + YEAR)
    assert sea.moved(ahead.pack(order())) == (True, {"signed": 1})
    tell_time(sea, NOW_S + 365 * 86_400, UNIT)  # by cable, link 0
    assert sea.moved(ahead.pack(order())) == (True, {"signed": 1})
    assert sea.moved(signer(at=NOW, system=66).pack(order())) == (False, {"replayed": 1})
    assert sea.moved(day_ahead_of(NOW + YEAR)) == (False, {"future_stamp": 1})
    stamps = [int.from_bytes(m.get_msgbuf()[-12:-6], "little") for m in sea.ticks[-1].messages(1)]
    assert all(stamp > NOW + YEAR for stamp in stamps)


def day_ahead_of(now: int) -> bytes:
    return signer(at=now + DAY, system=67).pack(order())


@pytest.mark.parametrize("sender", [UNIT, Station(LEADER, 1)], ids=["unsigned", "of another"])
def test_a_stranger_does_not_set_the_clock(sender: Station) -> None:
    sea = Sailor(clock_is_set=False)
    sea.boat.set_signing(0, "accept" if sender is UNIT else "off")
    for link_id, unix_s in enumerate((0, NOW_S + 365 * 86_400)):
        tell_time(sea, unix_s, sender)
        old = signer(at=NOW - DAY, system=66, link_id=link_id)
        assert sea.moved(old.pack(order())) == (True, {"signed": 1})  # it is still not judged


def test_a_host_with_a_clock_does_not_take_the_time_of_the_navigation_unit() -> None:
    sea = Sailor()
    tell_time(sea, NOW_S + 365 * 86_400, UNIT)
    assert sea.obeys_the_operator()


@pytest.mark.parametrize(
    ("ahead_s", "every_s"),
    [
        (lambda n: 86_400 * (n % 2) + n, 1.0),  # a day apart, by turns
        (lambda n: 86_400, 0.2),  # stands still
        (lambda n: 86_400 if n < 3 else -n, 0.1),  # one wrong time, three times
    ],
    ids=["disagree", "still", "copies"],
)
def test_a_wrong_time_does_not_set_the_clock(ahead_s: Callable[[int], int], every_s: float) -> None:
    """Signatures' times never go back: one from tomorrow would silence the boat for a day."""
    sea = Sailor(clock_is_set=False)
    for number in range(10):
        sea.say(system_time(NOW_S + ahead_s(number)), sender=UNIT)
        sea.run(every_s)
    said = [message for tick in sea.run(2.0) for message in tick.messages(1)]
    stamps = [int.from_bytes(message.get_msgbuf()[-12:-6], "little") for message in said]
    assert stamps and all(stamp < NOW + DAY / 2 for stamp in stamps)


def test_arming_reports_links_and_clocks_that_weaken_signing() -> None:
    for policies, clock_is_set, told in (
        (("required", "required"), True, []),
        (("off", "required"), True, ["unsigned messages accepted on link 0"]),
        (("accept", "off"), True, ["unsigned messages accepted on link 0 1"]),
        (("required", "required"), False, ["clock unknown: signature age not checked"]),
    ):
        sea = SecureSea("accept")
        sea.boat.on_host(unix_us=NOW_S * 1_000_000, clock_is_set=clock_is_set)
        for link, policy in enumerate(policies):
            sea.boat.set_signing(link, policy)
        tick = sea.hear(sea.operator.pack(command_long(ARM, 1.0)))
        said = [text for text in texts([tick], 1) if "PreArm" not in text and "HOLD" not in text]
        assert said == told
    plain = Sea()
    plain.settle()
    assert texts([plain.arm()]) == ["HOLD"]


def test_invalid_keys_and_policies_are_refused() -> None:
    boat = SecureSea("accept").boat
    for key in (b"", bytes(31), bytes(33)):
        with pytest.raises(ValueError, match="32 bytes"):
            boat.secure(key, 0)
    with pytest.raises(ValueError, match="required"):
        boat.set_signing(0, "always")
    for link in (-1, 2):
        with pytest.raises(IndexError):
            boat.set_signing(link, "off")
