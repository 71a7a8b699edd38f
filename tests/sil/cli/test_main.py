# SPDX-License-Identifier: MIT
"""The command line: mistakes are told in one line and change nothing."""

from pathlib import Path

import pytest

from sil.__main__ import main
from tests.sil.mistakes import assert_told_in_one_line


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["run", "dimond"], 'unknown scenario "dimond"; there are: current, diamond'),
        (["run", "nowhere.toml"], "nowhere.toml: No such file"),
        (["run", "diamond", "--set", "link.dely_s=1"], 'did you mean "delay_s"?'),
        (["run", "diamond", "--set", "duration_s=-1"], "greater than 0"),
        (["run", "diamond", "--set", "navigation.rate_hz=400"], "the world ticks at rate_hz = 100"),
        (["run", "diamond", "--seed", "-1"], "greater than or equal to 0"),
        (["run", "diamond", "--param", "LAW_KX"], "must be NAME=VALUE"),
        (["run", "diamond", "--param", "LAW_KX=9"], "LAW_KX = 9.0 is out of range"),
        (["run", "diamond", "--param", "LAW_KZ=1"], "unknown parameter LAW_KZ"),
    ],
)
def test_a_mistake_is_told_in_one_line(
    arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main([*arguments, "--out", str(out)]) == 2
    assert_told_in_one_line(said, capsys)
    assert not out.exists()


def test_results_that_cannot_be_written_are_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("in the way")
    assert main(["run", "turning", "--out", str(tmp_path / "file")]) == 2
    assert "file" in capsys.readouterr().err
