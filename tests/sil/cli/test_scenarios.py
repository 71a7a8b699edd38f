# SPDX-License-Identifier: MIT
"""The command that lists scenarios, and prints one to begin with."""

from pathlib import Path

import pytest

from sil.cli.main import main
from sil.scenario import scenario


def test_every_scenario_is_listed_with_its_first_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["scenarios"]) == 0
    listed = dict(line.split(maxsplit=1) for line in capsys.readouterr().out.splitlines())
    assert listed.keys() == {path.stem for path in scenario.FOLDER.glob("*.toml")}
    assert listed["paper_monte_carlo"].startswith("The paper's Monte Carlo")


def test_a_printed_scenario_can_be_sailed_as_a_file_of_ones_own(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["scenarios", "square"]) == 0
    mine = tmp_path / "mine.toml"
    mine.write_text(capsys.readouterr().out, encoding="utf-8")
    theirs, ours = (scenario.load(name) for name in ("square", mine))
    assert ours.model_dump(exclude={"name"}) == theirs.model_dump(exclude={"name"})


def test_an_unknown_scenario_is_answered_with_the_nearest_name(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert main(["scenarios", "squar"]) == 2
    assert 'did you mean "square"?' in capsys.readouterr().err
