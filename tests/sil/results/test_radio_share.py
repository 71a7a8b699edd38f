# SPDX-License-Identifier: MIT
"""Radios shared by several boats, and the cost of signatures, which pymavlink verifies."""

from itertools import product
from pathlib import Path

import pytest
from rich.console import Console

from sil.lockstep.recording import MAVLINK_OUT, Recording
from sil.lockstep.world import World
from sil.results import radio_share
from sil.results.radio_share import BOAT, KEY, PROFILE, RADIO, SIGNATURE, frames_of
from sil.scenario import scenario
from tests.dialect import dialect
from tests.each_push import few

NOW_S, EPOCH_S = 1_790_000_000, 1_420_070_400  # MAVLink counts from 2015


def test_a_signature_is_13_bytes_a_frame_and_pymavlink_finds_each_one_good(tmp_path: Path) -> None:
    World(scenario.load("diamond", ["duration_s=20"], "product"), {}).run(
        tmp_path / "run.bin", lambda _: None
    )
    recording = Recording(tmp_path / "run.bin")
    plain, signed = ([frame for _, frame in frames_of(recording, signs)] for signs in (False, True))
    port = (BOAT << 8) + MAVLINK_OUT + RADIO
    assert b"".join(plain) == b"".join(data for _, where, data in recording if where == port)
    # a tick has room for less that is signed: what is left over comes in the next, or after the end
    wanted = sum(len(frame) + SIGNATURE for frame in plain)
    assert sum(map(len, signed)) == pytest.approx(wanted, rel=0.02)
    ear = dialect().MAVLink(None)
    ear.signing.secret_key = KEY
    ear.signing.timestamp = (NOW_S - EPOCH_S) * 100_000
    heard = [ear.parse_buffer(frame) for frame in signed]
    assert all(len(each) == 1 and each[0].get_signed() for each in heard)
    assert ear.signing.sig_count == len(signed) and ear.signing.badsig_count == 0


def test_one_boat_leaves_three_fifths_of_a_radio(tmp_path: Path) -> None:
    wide, narrow = radio_share.one(tmp_path, limit_Bps=0), radio_share.one(tmp_path)
    assert narrow["share"] <= radio_share.TARGET_SHARE < wide["share"]
    assert narrow["bytes_per_s"].keys() == wide["bytes_per_s"].keys()
    for name in ("ATTITUDE", "LOCAL_POSITION_NED", "FORMATION_REFERENCE", "HEARTBEAT"):
        assert narrow["bytes_per_s"][name] == pytest.approx(wide["bytes_per_s"][name], rel=0.01)


@pytest.mark.parametrize(("loss", "delay_s"), few(product((0.0, 0.1), (0.1, 0.2)), [(0.1, 0.2)]))
def test_eight_boats_with_their_profile_share_a_radio_and_keep_their_slots(
    delay_s: float, loss: float, tmp_path: Path
) -> None:
    weather = (f"link.delay_s={delay_s}", f"link.loss={loss}")
    radio = radio_share.eight(tmp_path, PROFILE, *weather)
    assert radio["share"] <= radio_share.EIGHT_SHARE
    assert radio["rms_m"] <= radio_share.EIGHT_RMS_M
    assert "NAMED_VALUE_FLOAT" in radio["bytes_per_s"]  # telemetry is slowed down, not switched off


def test_the_table_has_shares_and_parameters_to_paste() -> None:
    radio: radio_share.Radio = {"bytes_per_s": {"HEARTBEAT": 34.0}, "share": 0.5, "rms_m": 0.02}
    console = Console(record=True, width=100)
    console.print(radio_share.table({"one boat": radio, "profile 8": radio}))
    told = console.export_text()
    assert "50.0 %" in told and "0.020" in told and "HEARTBEAT" in told
    assert f"profile 8: {radio_share.pasted(PROFILE)}" in told
    assert radio_share.pasted({"SR_SLOW": 0.25}) == "--param SR_SLOW=0.25"
