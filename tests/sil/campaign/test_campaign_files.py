# SPDX-License-Identifier: MIT
"""A campaign's folder: results bit for bit; a campaign never continues as another one."""

import errno
import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from sil.campaign.campaign_files import CampaignError, Folder, Identity
from sil.campaign.run_outcome import RunResult
from sil.campaign.work import ShareResult
from sil.common import files
from tests.sil.campaign.short import result

IDENTITY = Identity("calm", {"link": {"loss": 0.1}, "boat": [{"eta": [1, 2]}]}, {}, 3, 10, "abc")
FAILED = RunResult(12, 7, "failed", "why")


def kept(results: list[ShareResult]) -> list[RunResult]:
    return [run for batch in results for run in batch.runs]


def test_results_come_back_bit_for_bit(tmp_path: Path) -> None:
    odd = result(11, [[0.1, math.nan, math.inf]], "diverged")
    odd = replace(odd, boats=({"rms_error_m": math.nan, "max_error_m": 0.1 + 0.2},))
    batch = ShareResult((result(10, [[1 / 3, 2.0, 3.0]]), FAILED, odd), 1 / 7)
    assert Folder(tmp_path).begin(IDENTITY, "sail") == []
    Folder(tmp_path).keep(batch)
    back = Folder(tmp_path).begin(IDENTITY, "sail")
    assert back[0].busy_s == 1 / 7
    for was, now in zip(batch.runs, kept(back), strict=True):
        assert repr(now) == repr(was)
        np.testing.assert_array_equal(now.error_m, was.error_m)
        np.testing.assert_array_equal(now.psi_rad, was.psi_rad)


def test_an_unfinished_part_is_ignored(tmp_path: Path) -> None:
    folder = Folder(tmp_path)
    folder.begin(IDENTITY, "sail")
    folder.keep(ShareResult((FAILED,), 0.0))
    (tmp_path / "parts" / ".000003.npz.part").write_bytes(b"half")
    assert [run.run for run in kept(folder.begin(IDENTITY, "sail"))] == [12]


@pytest.mark.parametrize("bytes_left", [0, 10, 700, -30])
def test_a_damaged_part_is_reported_and_sailed_again(tmp_path: Path, bytes_left: int) -> None:
    folder = Folder(tmp_path)
    folder.begin(IDENTITY, "sail")
    for run in (3, 5):
        folder.keep(ShareResult((result(run, [[1.0, 2.0]]),), 0.0))
    part = tmp_path / "parts" / "000003.npz"
    part.write_bytes(part.read_bytes()[:bytes_left])
    said: list[str] = []
    assert [run.run for run in kept(folder.begin(IDENTITY, "sail", said.append))] == [5]
    assert len(said) == 1 and str(part) in said[0] and not part.exists()


@pytest.mark.parametrize("content", ["", '{"seed": 3', "[1]", "7"])
def test_a_damaged_campaign_is_reported_with_its_file(tmp_path: Path, content: str) -> None:
    Folder(tmp_path).begin(IDENTITY, "sail")
    (tmp_path / "campaign.json").write_text(content, encoding="utf-8")
    with pytest.raises(CampaignError, match=r"campaign\.json cannot be read"):
        Folder(tmp_path).begin(IDENTITY, "sail")


def test_a_full_disk_is_reported_with_the_file_that_has_no_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(path: Path, content: bytes) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(files, "replace", full)
    with pytest.raises(OSError, match=r"No space left on device: .*table\.parquet"):
        Folder(tmp_path).write("table.parquet", b"rows")


def test_a_folder_serves_one_command_at_a_time(tmp_path: Path) -> None:
    path = tmp_path / "out"
    with (
        Folder(path).alone(),
        pytest.raises(CampaignError, match="another command is at work in"),
        Folder(path).alone(),
    ):
        pass
    with Folder(path).alone():
        pass


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"seed": 4}, "seed: 3, now 4"),
        ({"runs": 11}, "runs: 10, now 11"),
        ({"parameters": {"LAW_KX": 0.1}}, "parameters.LAW_KX: null, now 0.1"),
        ({"document": {"link": {"loss": 0.2}, "boat": [{"eta": [1, 2]}]}}, "link.loss: 0.1, now 0"),
        ({"document": {"link": {"loss": 0.1}, "boat": [{"eta": [1, 3]}]}}, "document.boat"),
        ({"code": "abd"}, "its code"),
    ],
)
def test_an_unfinished_campaign_does_not_go_on_as_another(
    tmp_path: Path, changed: dict[str, object], said: str
) -> None:
    Folder(tmp_path).begin(IDENTITY, "sail away")
    other = Identity(**{**vars(IDENTITY), **changed})
    with pytest.raises(CampaignError) as told:
        Folder(tmp_path).begin(other, "sail")
    can = (
        "cannot finish that one: remove" if "code" in changed else "first, by sail away, or remove"
    )
    assert said in str(told.value) and can in str(told.value)
    assert Folder(tmp_path).begin(IDENTITY, "sail away") == []


def test_a_finished_campaign_makes_room_for_another(tmp_path: Path) -> None:
    folder = Folder(tmp_path)
    folder.begin(IDENTITY, "sail")
    folder.keep(ShareResult((FAILED,), 0.0))
    folder.write_json(IDENTITY, {"error": math.inf})
    folder.finish()
    assert not (tmp_path / "parts").exists()
    assert json.loads((tmp_path / "campaign.json").read_text(encoding="utf-8"))["error"] is None
    assert folder.begin(replace(IDENTITY, seed=4), "sail") == []
