# SPDX-License-Identifier: MIT
"""The sources that tools/view accepts, and its errors for others."""

import struct
from pathlib import Path

import pytest

from sil.cli.main import main
from sil.cli.view_command import source_of
from tests.sil.campaign.short import short
from tests.sil.view.feed import BEAT, local, said


@pytest.fixture(scope="module")
def sailed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a short run."""
    folder = tmp_path_factory.mktemp("sailed")
    assert main(["run", str(short(folder)), "--out", str(folder / "run")]) == 0
    return folder / "run"


def test_a_run_is_seen_by_its_folder_or_its_recording(sailed: Path) -> None:
    by_folder = source_of(str(sailed), None)
    assert isinstance(by_folder, dict) and by_folder["title"].startswith("short, seed ")
    assert source_of(str(sailed / "recording.bin"), None) == by_folder


def test_a_campaign_is_seen_by_its_worst_run(tmp_path: Path) -> None:
    out = tmp_path / "campaign"
    path = str(short(tmp_path))
    assert main(["campaign", path, "--runs", "2", "--workers", "1", "--out", str(out)]) == 0
    history = source_of(str(out), None)
    assert isinstance(history, dict) and "the worst of 2" in history["title"]


def test_a_file_is_a_tlog(tmp_path: Path) -> None:
    path = tmp_path / "log"
    path.write_bytes(
        struct.pack(">Q", 5) + said(1, BEAT) + struct.pack(">Q", 6) + said(1, local(1, 2))
    )
    history = source_of(str(path), 3.0)
    assert isinstance(history, dict) and history["vessels"][0]["length_m"] == 3.0


@pytest.mark.parametrize(
    ("source", "words"),
    [
        ("nowhere", "no file, no folder and no MAVLink address"),
        ("mcast:x", "must be mcast:"),
        ("mcast:239.255.145.67:14999:192.0.2.1", "no interface of this computer"),
        ("udpin:192.0.2.1:14999", "no interface of this computer has that address"),
        (".", "is not the folder of a run"),
        (__file__, "is not a tlog"),
    ],
)
def test_an_impossible_source_is_reported_in_one_line(
    source: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["view", source]) == 2
    told = capsys.readouterr().err
    assert told.startswith("error: ") and words in told and told.count("\n") == 1


@pytest.mark.parametrize(
    ("content", "words"),
    [
        ("", "a chart is a GeoJSON file"),
        ('{"type": "Feature"}', "geometry"),
        ('{"type": "Point", "coordinates": [1, 2]}', "contains no lines or polygons"),
        ('{"type": "LineString", "coordinates": [[500000, 4000000]]}', "in degrees"),
        ('{"type": "Sea"}', '"Sea" is not a GeoJSON type'),
    ],
)
def test_a_file_that_is_not_a_chart_is_reported(
    content: str, words: str, sailed: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "chart"
    path.write_text(content)
    assert main(["view", str(sailed), "--chart", str(path)]) == 2
    told = capsys.readouterr().err
    assert str(path) in told and words in told and told.count("\n") == 1


@pytest.mark.parametrize("length", ["nan", "inf", "0", "-1", "long"])
def test_an_invalid_length_is_refused(length: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["view", "mcast:", f"--length={length}"])
    assert "--length" in capsys.readouterr().err
