# SPDX-License-Identifier: MIT
"""Folders that a verb writes its results into, and those that it leaves alone."""

from pathlib import Path

import pytest

from sil.cli.main import main
from sil.common.out_folder import claim


def summary(folder: Path, text: str) -> Path:
    folder.mkdir()
    (folder / "summary.json").write_text(text, encoding="utf-8")
    (folder / "report.html").touch()
    return folder


def test_new_interrupted_and_own_folders_are_taken(tmp_path: Path) -> None:
    (tmp_path / "interrupted" / "boat1").mkdir(parents=True)
    own = summary(tmp_path / "own", '{"scenario": "noisy"}')
    for folder in (tmp_path / "new", tmp_path / "interrupted", own):
        assert claim(folder, "summary.json", "noisy") == folder


def test_page_of_another_command_is_not_overwritten(tmp_path: Path) -> None:
    (tmp_path / "report.html").touch()
    with pytest.raises(ValueError, match="holds files that this command has not made"):
        claim(tmp_path, "summary.json", "noisy")


@pytest.mark.parametrize(
    ("held", "said"),
    [
        ('{"scenario": "sea"}', 'holds the results of "sea": name another folder with --out'),
        ("{}", "holds files that this command has not made"),
        ("[1]", "holds files that this command has not made"),
        ("no JSON", "holds files that this command has not made"),
    ],
)
def test_files_made_by_something_else_are_not_overwritten(
    tmp_path: Path, held: str, said: str
) -> None:
    folder = summary(tmp_path / "held", held)
    with pytest.raises(ValueError, match=said):
        claim(folder, "summary.json", "noisy")


def test_file_is_refused_as_a_folder(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ValueError, match="is a file; name a folder"):
        claim(tmp_path / "file", "summary.json", "noisy")


def test_run_does_not_overwrite_that_of_another_scenario(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = summary(tmp_path / "held", '{"scenario": "sea"}')
    for verb in ("run", "certify"):
        assert main([verb, "noisy", "--out", str(folder)]) == 2
        assert f"{folder} holds" in capsys.readouterr().err
    assert {path.name for path in folder.iterdir()} == {"summary.json", "report.html"}
