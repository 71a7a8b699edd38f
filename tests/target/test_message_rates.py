# SPDX-License-Identifier: MIT
"""Message rates: defaults, a client's requests, the capacity of a link."""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import common as mavlink

from tests.target.operator_words import command_int, param_list, param_set
from tests.target.sea import Sea, Tick, acks, messages, named
from tests.target.stations import (
    ACCEPTED,
    BOAT,
    DENIED,
    GCS,
    GET_INTERVAL,
    HOLD,
    ORIGIN,
    SET_INTERVAL,
    UNSUPPORTED,
    Station,
    command_long,
    heartbeat,
    kind_of,
)

HEARTBEAT, ATTITUDE, POSITION, FOLLOW_TARGET, EXTENDED_STATE = 0, 30, 32, 144, 245
NAMED_VALUE = 251
NEVER, DEFAULT = -1.0, 0.0
#: Number of messages in ten seconds by default.
IN_TEN_SECONDS = {
    1: 10,
    2: 10,
    30: 100,
    32: 100,
    33: 20,
    49: 10,
    62: 10,
    85: 10,
    FOLLOW_TARGET: 0,
    147: 2,
    242: 5,
    EXTENDED_STATE: 0,
    NAMED_VALUE: 10,
    290: 0,
    291: 0,
    436: 0,
}
EACH = pytest.mark.parametrize("message_id", list(IN_TEN_SECONDS))
RADIO = Station(51, 68)  # the ids of SiK radios


def count(ticks: list[Tick], message_id: int, link: int = 0) -> int:
    """The number of messages with that id; of NAMED_VALUE_FLOAT, the number of one value."""
    found = named(ticks, kind_of(message_id), link)
    return len([m for m in found if message_id != NAMED_VALUE or m.name == "OVERRUNS"])


def said(sea: Sea, message_id: int, seconds: float = 10.0) -> int:
    return count(sea.run(seconds), message_id)


def ask(sea: Sea, message_id: float, interval_us: float, link: int = 0) -> int:
    ((command, result),) = acks(sea.order(SET_INTERVAL, message_id, interval_us, link=link), link)
    assert command == SET_INTERVAL
    return int(result)


def interval_us(sea: Sea, message_id: int, link: int = 0) -> int:
    tick = sea.order(GET_INTERVAL, message_id, link=link)
    (told,) = tick.named("MESSAGE_INTERVAL", link)
    assert told.message_id == message_id
    return int(told.interval_us)


@pytest.fixture
def settled(sea: Sea) -> Sea:
    """A boat that knows everything it can send."""
    sea.run(1.5)
    return sea


def test_every_message_is_sent_at_its_default_rate(settled: Sea) -> None:
    ticks = settled.run(10.0)
    for message_id, times in IN_TEN_SECONDS.items():
        assert count(ticks, message_id) == times, kind_of(message_id)


@EACH
def test_a_message_comes_as_often_as_a_client_wants_it(settled: Sea, message_id: int) -> None:
    assert ask(settled, message_id, 250_000.0) == ACCEPTED
    assert interval_us(settled, message_id) == 250_000
    assert said(settled, message_id, 5.0) == pytest.approx(20, abs=1)


@EACH
def test_a_message_that_a_client_has_turned_off_never_comes(settled: Sea, message_id: int) -> None:
    assert ask(settled, message_id, NEVER) == ACCEPTED
    assert interval_us(settled, message_id) == -1
    assert said(settled, message_id) == 0


@EACH
def test_a_client_gets_the_default_back(settled: Sea, message_id: int) -> None:
    before_us = interval_us(settled, message_id)
    for wanted_us in (50_000.0, NEVER):
        ask(settled, message_id, wanted_us)
        assert ask(settled, message_id, DEFAULT) == ACCEPTED
        assert interval_us(settled, message_id) == before_us
    assert said(settled, message_id) == pytest.approx(IN_TEN_SECONDS[message_id], abs=1)


@EACH
@pytest.mark.parametrize("interval", [1.0, 9_999.0])
def test_nothing_comes_more_often_than_the_tick(
    settled: Sea, message_id: int, interval: float
) -> None:
    assert ask(settled, message_id, interval) == ACCEPTED
    assert interval_us(settled, message_id) == settled.period_us
    assert said(settled, message_id, 0.5) == 50


@pytest.mark.parametrize("message_id", [0, ATTITUDE, FOLLOW_TARGET, 9999])
@pytest.mark.parametrize("interval", [math.nan, math.inf, -math.inf, -2.0, 1e30])
def test_an_interval_that_makes_no_sense_is_denied_and_changes_nothing(
    settled: Sea, message_id: int, interval: float
) -> None:
    before_us = interval_us(settled, message_id)
    assert ask(settled, message_id, interval) == DENIED
    assert interval_us(settled, message_id) == before_us


@pytest.mark.parametrize("message_id", [math.nan, math.inf, -1.0, 30.5, 1e30])
def test_an_interval_of_no_message_is_denied(settled: Sea, message_id: float) -> None:
    assert ask(settled, message_id, 1e5) == DENIED


@pytest.mark.parametrize("message_id", [4, 25, 22, 73, 148, 244, 253, 331, 397, 435, 9999])
def test_an_interval_of_a_message_sent_only_on_request_is_unsupported(
    settled: Sea, message_id: int
) -> None:
    assert ask(settled, message_id, 1e5) == UNSUPPORTED
    assert ask(settled, message_id, NEVER) == UNSUPPORTED
    settled.ticks.clear()
    settled.run(1.0)
    assert message_id not in {m.get_msgId() for m in messages(settled.ticks)}


@pytest.mark.parametrize("interval", [1e5, 5e6, NEVER, DEFAULT])
def test_the_heartbeats_rate_cannot_be_changed(settled: Sea, interval: float) -> None:
    assert ask(settled, HEARTBEAT, interval) == DENIED
    assert said(settled, HEARTBEAT) == 10


def test_a_command_int_asks_for_a_rate_too(settled: Sea) -> None:
    settled.say(command_int(SET_INTERVAL, ATTITUDE, 20_000.0))
    assert acks(settled.step()) == [(SET_INTERVAL, ACCEPTED)]
    assert said(settled, ATTITUDE, 1.0) == 50


def test_every_link_has_rates_of_its_own() -> None:
    sea = Sea(links=3)
    sea.run(1.5)
    assert ask(sea, ATTITUDE, 20_000.0, link=1) == ACCEPTED
    assert ask(sea, ATTITUDE, NEVER, link=2) == ACCEPTED
    assert ask(sea, FOLLOW_TARGET, 100_000.0, link=2) == ACCEPTED
    assert [interval_us(sea, ATTITUDE, link) for link in range(3)] == [100_000, 20_000, -1]
    assert [interval_us(sea, FOLLOW_TARGET, link) for link in range(3)] == [-1, -1, 100_000]
    ticks = sea.run(2.0)
    assert [len(named(ticks, "ATTITUDE", link)) for link in range(3)] == [20, 100, 0]
    assert [len(named(ticks, "FOLLOW_TARGET", link)) for link in range(3)] == [0, 0, 20]


def test_the_same_rate_asked_for_twice_is_that_rate(settled: Sea) -> None:
    for _ in range(4):
        assert ask(settled, ATTITUDE, 50_000.0) == ACCEPTED
        settled.run(0.3)
    assert said(settled, ATTITUDE, 2.0) == pytest.approx(40, abs=1)


def test_a_rate_asked_for_outlives_a_change_of_state_and_of_parameters(settled: Sea) -> None:
    ask(settled, ATTITUDE, 20_000.0)
    ask(settled, 33, NEVER)
    settled.say(param_set("SR_STATE", 5.0))
    settled.step()
    settled.arm()
    settled.mode(6)
    assert said(settled, ATTITUDE, 2.0) == pytest.approx(100, abs=1)
    assert said(settled, POSITION, 2.0) == pytest.approx(10, abs=1)  # the default has changed
    assert said(settled, 33, 2.0) == 0


def test_a_message_without_data_yet_comes_as_requested_once_it_can(sea: Sea) -> None:
    sea.own.on = False
    sea.run(1.0)
    assert ask(sea, FOLLOW_TARGET, 100_000.0) == ACCEPTED
    assert said(sea, FOLLOW_TARGET, 1.0) == 0
    sea.own.on = True
    sea.run(0.5)
    assert said(sea, FOLLOW_TARGET, 1.0) == 10


def test_a_slow_link_is_asked_for_no_more_than_it_carries() -> None:
    sea = Sea(links=2)
    sea.boat.limit_link(1, 400)
    sea.run(1.5)
    assert ask(sea, ATTITUDE, 1.0, link=1) == ACCEPTED
    assert interval_us(sea, ATTITUDE, link=1) >= 1e6 * 40 / 400
    assert ask(sea, ATTITUDE, 1.0, link=0) == ACCEPTED
    assert interval_us(sea, ATTITUDE, link=0) == sea.period_us
    ticks = sea.run(30.0)
    sent = sum(len(data) for tick in ticks for link, data in tick.mavlink if link == 1)
    assert sent < 30 * 400 * 1.15
    assert len(named(ticks, "HEARTBEAT", link=1)) == 30
    assert len(named(ticks, "ATTITUDE", link=0)) == 3000


def radio_says(sea: Sea, txbuf: int, times: int = 1, link: int = 0) -> None:
    for _ in range(times):
        message = mavlink.MAVLink_radio_status_message(200, 200, txbuf, 40, 40, 0, 0)
        sea.say(message, sender=RADIO, link=link)
    sea.step()


def complaining(
    sea: Sea, seconds: float, txbuf: int = 40, every_s: float = 0.5, link: int = 0
) -> list[Tick]:
    """A radio that repeatedly reports its free buffer, %; 35 to 50 changes nothing."""
    ticks: list[Tick] = []
    for _ in range(round(seconds / every_s)):
        message = mavlink.MAVLink_radio_status_message(200, 200, txbuf, 40, 40, 0, 0)
        sea.say(message, sender=RADIO, link=link)
        ticks += sea.run(every_s)
    return ticks


@pytest.mark.parametrize(
    ("txbuf", "factor"),
    [(0, 0.8), (24, 0.8), (25, 0.975), (34, 0.975), (35, 1.0), (50, 1.0), (51, 1.0), (100, 1.0)],
)
def test_telemetry_backs_off_as_a_radios_buffer_fills(
    settled: Sea, txbuf: int, factor: float
) -> None:
    ask(settled, FOLLOW_TARGET, 100_000.0)
    radio_says(settled, txbuf, times=5)
    complaining(settled, 1.0)
    expected = 10.0 * 10.0 * factor**5
    ticks = complaining(settled, 10.0)
    for message_id in (POSITION, ATTITUDE, FOLLOW_TARGET):
        assert count(ticks, message_id) == pytest.approx(expected, abs=1)


def test_a_full_radio_gets_a_twentieth_but_the_state_twice_a_second(settled: Sea) -> None:
    """And every HEARTBEAT: followers could not steer with less."""
    ask(settled, FOLLOW_TARGET, 100_000.0)
    radio_says(settled, 0, times=50)
    complaining(settled, 2.0, 0)
    ticks = complaining(settled, 40.0, 0)
    assert count(ticks, FOLLOW_TARGET) == pytest.approx(40 * 10 * 0.05, abs=1)
    assert count(ticks, POSITION) == pytest.approx(80, abs=1)
    assert count(ticks, ATTITUDE) == pytest.approx(80, abs=1)
    assert count(ticks, HEARTBEAT) == 40
    assert (400, ACCEPTED) in acks(settled.arm())


@pytest.mark.parametrize("rate_Hz", [1.0, 0.5])
def test_a_state_that_is_slower_anyway_stays_as_it_is(rate_Hz: float) -> None:
    sea = Sea({"SR_STATE": rate_Hz})
    sea.run(1.5)
    radio_says(sea, 0, times=50)
    complaining(sea, 4.0, 0)
    ticks = complaining(sea, 20.0, 0)
    assert count(ticks, POSITION) == pytest.approx(20 * rate_Hz, abs=1)
    assert count(ticks, ATTITUDE) == pytest.approx(20 * rate_Hz, abs=1)


def test_a_full_radio_gets_no_state_if_sr_state_is_zero() -> None:
    sea = Sea({"SR_STATE": 0})
    sea.run(1.5)
    radio_says(sea, 0, times=50)
    assert not count(complaining(sea, 5.0, 0), POSITION)


def test_a_radio_silent_for_five_seconds_no_longer_slows_its_link(settled: Sea) -> None:
    radio_says(settled, 0, times=50)
    assert said(settled, POSITION, 4.9) == pytest.approx(10, abs=1)
    settled.run(0.7)  # the turn after that
    assert said(settled, POSITION, 5.0) == pytest.approx(50, abs=1)
    radio_says(settled, 0)  # and begins anew
    assert said(settled, POSITION, 4.0) == pytest.approx(32, abs=1)


def test_a_radio_that_keeps_reporting_keeps_slowing_its_link(settled: Sea) -> None:
    radio_says(settled, 0, times=50)
    ticks = complaining(settled, 24.0, every_s=4.0)
    assert count(ticks, POSITION) == pytest.approx(48, abs=1)


def test_telemetry_comes_back_as_the_buffer_empties(settled: Sea) -> None:
    ask(settled, FOLLOW_TARGET, 100_000.0)
    radio_says(settled, 0, times=50)
    radio_says(settled, 100, times=28)  # 0.05 × 1.025^28 = 0.0998
    complaining(settled, 2.0)
    ticks = complaining(settled, 20.0)
    assert count(ticks, FOLLOW_TARGET) == pytest.approx(20, abs=1)
    radio_says(settled, 100, times=100)
    complaining(settled, 2.0)
    assert count(complaining(settled, 10.0), FOLLOW_TARGET) == 100
    radio_says(settled, 100, times=50)  # never more than was asked for
    assert count(complaining(settled, 10.0), FOLLOW_TARGET) == 100


def test_a_radio_slows_requested_streams_too(settled: Sea) -> None:
    ask(settled, ATTITUDE, 20_000.0)
    radio_says(settled, 10, times=5)
    complaining(settled, 1.0)
    assert count(complaining(settled, 10.0), ATTITUDE) == pytest.approx(500 * 0.8**5, abs=2)
    ask(settled, ATTITUDE, 50_000.0)  # as the radio is still full
    complaining(settled, 1.0)
    assert count(complaining(settled, 10.0), ATTITUDE) == pytest.approx(200 * 0.8**5, abs=2)


def test_a_radio_slows_its_own_link_only() -> None:
    sea = Sea(links=2)
    sea.run(1.5)
    radio_says(sea, 0, times=50, link=1)
    ticks = complaining(sea, 10.0, link=1)
    assert len(named(ticks, "ATTITUDE", link=0)) == 100
    assert len(named(ticks, "ATTITUDE", link=1)) <= 21


@pytest.mark.parametrize("station", [(51, 69), (GCS, 190), (BOAT, 197)], ids=str)
def test_radio_status_of_other_systems_slows_no_link(
    settled: Sea, station: tuple[int, int]
) -> None:
    for _ in range(50):
        message = mavlink.MAVLink_radio_status_message(200, 200, 0, 40, 40, 0, 0)
        settled.say(message, sender=Station(*station))
    assert count(settled.run(10.0), ATTITUDE) == pytest.approx(100, abs=1)


@pytest.mark.parametrize("txbuf", [101, 200, 255])
def test_a_radio_that_does_not_know_its_buffer_changes_nothing(settled: Sea, txbuf: int) -> None:
    radio_says(settled, 0, times=3)
    radio_says(settled, txbuf, times=50)
    assert said(settled, POSITION, 4.5) == pytest.approx(45 * 0.8**3, abs=1)


def test_a_change_of_state_is_reported_at_once_on_any_radio(settled: Sea) -> None:
    radio_says(settled, 0, times=50)
    settled.arm()
    tick = settled.mode(6)
    kinds = [m.get_type() for m in tick.messages()]
    assert {"HEARTBEAT", "STATUSTEXT"} <= set(kinds)
    assert tick.named("HEARTBEAT")[-1].custom_mode == 6
    assert settled.mode(HOLD).named("HEARTBEAT")[-1].custom_mode == HOLD


def test_the_origin_keeps_its_own_rate_whatever_others_get(settled: Sea) -> None:
    ask(settled, ATTITUDE, 10_000.0)
    settled.say(heartbeat(), command_long(SET_INTERVAL, 32.0, 10_000.0))
    sent = named(settled.run(5.0), "GPS_GLOBAL_ORIGIN")
    assert len(sent) == 5 and all((m.latitude, m.longitude) == ORIGIN[:2] for m in sent)


@pytest.mark.parametrize("bytes_per_s", [400, 800, 1200])
def test_a_slow_radio_starves_no_message_for_good(bytes_per_s: int) -> None:
    """Followers need origin and position; operators need the health."""
    sea = Sea({"FS_SLOT_M": 0.0}, links=2)
    sea.boat.limit_link(1, bytes_per_s)
    sea.enter_formation()
    ticks = sea.run(60.0)
    for message_id, times in IN_TEN_SECONDS.items():
        if times:
            assert count(ticks, message_id, link=1) > 0, kind_of(message_id)
    assert count(ticks, 49, link=1) >= 5
    assert count(ticks, HEARTBEAT, link=1) == 60


@pytest.mark.parametrize("bytes_per_s", [600, 1200])
def test_a_slow_radio_carries_the_parameters_in_the_end(bytes_per_s: int) -> None:
    """38 of them are 1.4 kB: at a third of the radio some 7 s."""
    sea = Sea(links=2)
    sea.boat.limit_link(1, bytes_per_s)
    sea.run(1.5)
    sea.say(param_list(), link=1)
    found = named(sea.run(60.0), "PARAM_VALUE", link=1)
    assert {m.param_index for m in found} >= set(range(len(sea.boat.parameters())))
    sea.say(param_set("FORM_OFS_N", 3.0), link=1)
    assert named(sea.run(5.0), "PARAM_VALUE", link=1)


@pytest.mark.parametrize("message_id", [148, NAMED_VALUE])
def test_many_questions_do_not_silence_the_heartbeat(settled: Sea, message_id: int) -> None:
    """Excess requests get fewer answers; without a HEARTBEAT everybody would lose the boat."""
    settled.ticks.clear()
    for _ in range(500):
        settled.say(*[command_long(SET_INTERVAL + 1, float(message_id)) for _ in range(24)])
        settled.step()
    assert count(settled.ticks, HEARTBEAT) == 5
    assert count(settled.ticks, POSITION) > 10
    assert (400, ACCEPTED) in acks(settled.arm())
