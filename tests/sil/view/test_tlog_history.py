# SPDX-License-Identifier: MIT
"""Histories of tlogs: equal to what a live view would have shown."""

import random
import struct
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from sil.plant.hull import Array
from sil.scenario import scenario
from sil.view.history import MOST_SAMPLES, numbers
from sil.view.seen_fleet import FORGOTTEN_S, Fleet
from sil.view.tlog_history import Watch, history_of_tlog, messages_of
from sil.wire.mavlink_ear import Ear
from sil.wire.mavlink_frames import frames
from sil.wire.tlog import packets
from tests.sil.view.feed import BEAT, VIRTUAL, attitude, local, said, sail_and_look, value

START_US = 1_700_000_000_000_000
DURATION_S = 30


def record(t_us: int, data: bytes) -> bytes:
    return b"".join(struct.pack(">Q", t_us) + frame for *_, frame in frames(data))


@pytest.fixture(scope="module")
def sailed(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Array]:
    """A tlog of all radio traffic of a run of `diamond`, and the truth at each tick."""
    content, truth = bytearray(), []

    def look(k: int, chunks: list[bytes], eta: Array) -> None:
        truth.append(eta.copy())
        for chunk in chunks:
            content.extend(record(START_US + 10_000 * k, chunk))

    sail_and_look(
        look,
        f"duration_s={DURATION_S}",
        "parameters.SR_STATE=20",
        "fault=[{kind='radio_silent', agent=0, at_s=15.0}]",
    )
    path = tmp_path_factory.mktemp("tlog") / "fleet.tlog"
    path.write_bytes(content)
    return path, np.array(truth)


def by_id(history: dict[str, Any]) -> dict[int, dict[str, Any]]:
    return {vessel["id"]: vessel for vessel in history["vessels"]}


def test_every_message_that_pymavlink_reads_is_read_at_its_time(
    sailed: tuple[Path, Array],
) -> None:
    log = mavutil.mavlogfile(str(sailed[0]))
    theirs = [(m._timestamp - 1e-6 * START_US, m.get_msgId()) for m in iter(log.recv_msg, None)]
    log.close()
    ours = [(t_s, m.number) for t_s, m in messages_of(packets(sailed[0].read_bytes(), []))]
    known = {number for _, number in ours}
    theirs = [(t_s, number) for t_s, number in theirs if number in known]
    known = {number for _, number in theirs}
    ours = [(t_s, number) for t_s, number in ours if number in known]
    assert [number for _, number in ours] == [number for _, number in theirs]
    assert [t_s for t_s, _ in ours] == pytest.approx([t_s for t_s, _ in theirs], abs=1e-4)


def test_boats_are_played_back_where_they_were(sailed: tuple[Path, Array]) -> None:
    history, truth = history_of_tlog(sailed[0], 1.5), sailed[1]
    t_s, vessels = numbers(history["t_s"]), by_id(history)
    assert list(vessels) == [1, 2, 3, 4, 100] and t_s[-1] == pytest.approx(DURATION_S, abs=0.2)
    late = (t_s > 3.0) & (t_s < DURATION_S)
    ticks = np.round(100.0 * t_s[late]).astype(int)
    for agent in range(1, 5):
        for axis, name in enumerate(("x_m", "y_m")):
            shown = numbers(vessels[agent][name])[late]
            # what was told up to 0.05 s before, at some 1.5 m/s
            np.testing.assert_allclose(shown, truth[ticks, agent, axis], atol=0.12)
        assert vessels[agent]["length_m"] == 1.5 and vessels[agent]["limits_N"] == [-50.0, 50.0]
    follows = [boat.follows for boat in scenario.load("diamond").boat]
    assert [vessels[i]["leader"] for i in (1, 2, 3, 4)] == [follow or 100 for follow in follows]
    assert vessels[100]["kind"] == "leader"


def test_states_and_unmet_conditions_are_played_back(sailed: tuple[Path, Array]) -> None:
    vessel = by_id(history_of_tlog(sailed[0]))[1]
    assert [state for _, state in vessel["states"]] == ["FORMATION", "COAST", "HOLD"]
    assert 15.5 < vessel["states"][1][0] < 17.0
    assert vessel["held"][-1][1] == ["leader lost or origin unknown"]
    ages = numbers(by_id(history_of_tlog(sailed[0]))[100]["link_age_s"])
    assert ages[-1] == pytest.approx(0.0, abs=1.0)


def test_esc_data_is_played_back_and_missing_data_has_no_column(
    sailed: tuple[Path, Array],
) -> None:
    vessels = by_id(history_of_tlog(sailed[0]))
    for side in ("port", "stbd"):
        rpm, voltage_V = (
            numbers(vessels[2][f"{side}_rpm"]),
            numbers(vessels[2][f"{side}_voltage_V"]),
        )
        assert np.nanmax(np.abs(rpm)) > 100 and np.nanmax(voltage_V) == np.nanmin(voltage_V) == 24.0
        assert f"{side}_temperature_C" not in vessels[2] and f"{side}_rpm" not in vessels[100]


def test_damage_loses_only_the_messages_that_it_hits(
    sailed: tuple[Path, Array], tmp_path: Path
) -> None:
    rng, content = random.Random(4), bytearray(sailed[0].read_bytes())
    whole = sum(1 for _ in messages_of(packets(bytes(content), [])))
    for _ in range(50):
        content[rng.randrange(len(content))] ^= 0xFF
    del content[:5], content[-3:]
    assert whole - 110 <= sum(1 for _ in messages_of(packets(bytes(content), []))) < whole
    path = tmp_path / "damaged.tlog"
    path.write_bytes(content)
    assert len(history_of_tlog(path)["vessels"]) == 5


def written(path: Path, times_us: list[int]) -> Path:
    wire = [record(t, said(1, BEAT, attitude(0.0), local(1e-6 * t, 0.0))) for t in times_us]
    path.write_bytes(b"".join(wire))
    return path


def test_a_long_log_has_no_more_samples_than_a_page_takes(tmp_path: Path) -> None:
    path = written(tmp_path / "long.tlog", [500_000 * k for k in range(4_000)])
    history = history_of_tlog(path)
    t_s, x_m = numbers(history["t_s"]), numbers(history["vessels"][0]["x_m"])
    assert MOST_SAMPLES // 2 - 2 <= t_s.size <= MOST_SAMPLES
    assert np.allclose(np.diff(t_s[:-1]), t_s[1] - t_s[0], rtol=1e-3)
    known = ~np.isnan(x_m)
    assert known.sum() > t_s.size - 3
    np.testing.assert_allclose(x_m[known], t_s[known], atol=0.6)


def test_a_clock_set_during_the_log_adds_no_time(tmp_path: Path) -> None:
    times_us = [10_000_000 + 100_000 * k for k in range(50)]
    times_us += [START_US + 100_000 * k for k in range(50)] + [
        9_000_000 + 100_000 * k for k in range(50)
    ]
    t_s = numbers(history_of_tlog(written(tmp_path / "set.tlog", times_us))["t_s"])
    assert t_s[-1] == pytest.approx(14.7, abs=0.3)


def test_asking_for_a_history_does_not_change_it() -> None:
    watch, asked = Watch(Fleet(1.0)), Watch(Fleet(1.0))
    for k in range(100):
        for each in (watch, asked):
            for message in Ear(stream=False).hear(said(1 + k // 50, BEAT, local(0.1 * k, 0.0))):
                each.hear(0.1 * k + 0.05, message)
        asked.history("so far")
    assert asked.times == watch.times
    assert asked.history("") == watch.history("")


def test_a_boat_that_comes_late_and_goes_is_unknown_before_and_silent_after(tmp_path: Path) -> None:
    wire = b"".join(
        record(1_000_000 * k, said(1, BEAT, local(0.0, 0.0)))
        + (record(1_000_000 * k, said(2, BEAT, local(1.0, 0.0))) if 20 < k < 40 else b"")
        for k in range(150)
    )
    path = tmp_path / "late.tlog"
    path.write_bytes(wire)
    history = history_of_tlog(path)
    t_s, x_m = numbers(history["t_s"]), numbers(by_id(history)[2]["x_m"])
    assert np.isnan(x_m[t_s < 20.5]).all() and (x_m[t_s > 22] == 1.0).all()
    ages_s = numbers(by_id(history)[2]["link_age_s"])
    np.testing.assert_allclose(ages_s[t_s > 40], t_s[t_s > 40] - 39.0, atol=0.02)


def logged(path: Path, told: list[tuple[int, bytes]]) -> dict[str, Any]:
    """The history of a log of messages at given seconds."""
    path.write_bytes(b"".join(record(START_US + 1_000_000 * t_s, data) for t_s, data in told))
    return history_of_tlog(path)


def test_a_leader_that_is_forgotten_stays_silent_until_it_is_heard_again(tmp_path: Path) -> None:
    told = [(t_s, said(1, BEAT)) for t_s in range(200)]
    told += [(t_s, said(100, VIRTUAL, local(1.0, 1.0))) for t_s in (5, 150)]
    history = logged(tmp_path / "gap.tlog", sorted(told))
    t_s, ages_s = numbers(history["t_s"]), numbers(by_id(history)[100]["link_age_s"])
    assert np.isnan(ages_s[t_s < 5.0]).all()
    assert (ages_s[(t_s > 10.1) & (t_s < 149.9)] > 5.0).all()
    assert (ages_s[(t_s > 66.0) & (t_s < 149.9)] == FORGOTTEN_S).all()
    assert (ages_s[(t_s > 150.5) & (t_s < 154.0)] < 5.0).all()


def test_the_state_of_a_boat_that_lost_its_heartbeat_alone_is_unknown(tmp_path: Path) -> None:
    told = [(t_s, said(1, BEAT)) for t_s in range(11)]
    told += [(t_s, said(1, value("E_X", 0.0))) for t_s in range(30)]
    (known, lost) = logged(tmp_path / "beat.tlog", sorted(told))["vessels"][0]["states"]
    assert known == [0.0, "FORMATION"]
    assert lost == [pytest.approx(16.0, abs=0.5), None]


def test_texts_are_played_back_with_their_severities(tmp_path: Path) -> None:
    texts = [mavlink.MAVLink_statustext_message(level, b"%d" % level) for level in (2, 2, 6)]
    told = [(t_s, said(1, BEAT, text)) for t_s, text in enumerate(texts)]
    (vessel,) = logged(tmp_path / "texts.tlog", told)["vessels"]
    assert vessel["texts"] == [[0.0, "2"], [2.0, "6"]]
    assert vessel["severities"] == [[0.0, 2], [2.0, 6]]


@pytest.mark.parametrize("content", [b"", b"no log at all", bytes(1000), b"\xfd" * 1000])
def test_a_file_that_is_no_tlog_is_refused(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "x.tlog"
    path.write_bytes(content)
    with pytest.raises(ValueError, match="is not a tlog"):
        history_of_tlog(path)


def test_bytes_that_only_look_like_unknown_messages_are_no_tlog(tmp_path: Path) -> None:
    path = tmp_path / "other.bin"
    unknown = bytes([0xFD, 1, 0, 0, 7, 1, 1, 0xEE, 0xEE, 0xEE, 5, 9, 9])
    path.write_bytes(bytes(8) + 4 * unknown)
    with pytest.raises(ValueError, match="it contains no MAVLink message"):
        history_of_tlog(path)
