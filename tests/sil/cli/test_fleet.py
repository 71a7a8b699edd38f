# SPDX-License-Identifier: MIT
"""A mistake in an order to a fleet is told before any boat is waited for."""

import argparse
from pathlib import Path

import pytest

from sil.cli import fleet_command
from sil.cli.main import main
from tests.sil.mistakes import assert_told_in_one_line


@pytest.fixture(autouse=True)
def no_link(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(address: str) -> None:
        raise AssertionError(f"opens {address}")

    monkeypatch.setattr("sil.fleet.ends.end_at", refuse)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["form", "vea", "--spacing", "3"], 'unknown shape "vea"; did you mean "vee"?'),
        (["form", "line"], "line: --spacing M is missing"),
        (["form", "line", "--spacing", "nan"], "--spacing nan: must be greater than 0"),
        (["form", "line", "--spacing=-1"], "--spacing -1: must be greater than 0"),
        (["form", "nowhere.toml"], "nowhere.toml: No such file"),
        (["form", "empty.toml"], "empty.toml: must contain only places_m"),
        (["form", "no_places.toml"], "no_places.toml: places_m is empty"),
        (["form", "latin.toml"], "latin.toml: "),
        (["form", "no_places.toml", "--spacing", "3"], "--spacing: no_places.toml has the places"),
        (["status", "--spacing", "3"], "--spacing belongs to form, not to status"),
        (["arm", "--fixed"], "--fixed belongs to form, not to arm"),
        (["loiter", "--local", "1", "2"], "--local belongs to go, not to loiter"),
        (["go", "--local", "nan", "2"], "--local: both must be finite"),
        (["status", "--as", "7"], "--as belongs to serve, not to status"),
        (["arm", "--ground", "udpin:127.0.0.1:1"], "--ground belongs to serve, not to arm"),
    ],
)
def test_a_mistake_is_told_at_once(
    arguments: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("empty.toml").write_text("")
    Path("no_places.toml").write_text("places_m = []")
    Path("latin.toml").write_bytes(b"# \xe9")
    assert main(["fleet", *arguments]) == 2
    assert_told_in_one_line(said, capsys)


@pytest.mark.parametrize("action", ["stop", "hold", "disarm"])
def test_an_option_too_many_does_not_keep_a_fleet_from_stopping(action: str) -> None:
    parser = argparse.ArgumentParser()
    fleet_command.add_to(parser)
    others = ["--spacing", "3", "--fixed", "--local", "1", "2", "--as", "7"]
    options = parser.parse_args([action, *others])
    assert fleet_command._wish(options).action == action
