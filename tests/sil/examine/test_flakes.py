# SPDX-License-Identifier: MIT
from __future__ import annotations

import io
import os
from pathlib import Path

import pytest
from rich.console import Console

from sil.examine import flakes
from sil.examine.flakes import Task
from sil.lockstep.start import StartError
from sil.scenario.scenario import FOLDER

SCENARIOS = len(list(FOLDER.glob("*.toml")))


def quiet() -> Console:
    return Console(file=io.StringIO(), width=120)


def by_name(task: Task) -> str:
    return task[0]


def by_process(task: Task) -> str:
    return f"{task[0]} {os.urandom(8).hex()}"


def dies(task: Task) -> str:
    if task[0] == "sea":
        os._exit(3)
    return task[0]


def fails(task: Task) -> str:
    return "no digest: boat 1: not ready" if task[0] == "sea" else task[0]


def test_runs_with_equal_digests_are_not_reported() -> None:
    assert flakes.lockstep(3 * SCENARIOS, quiet(), by_name) == 0


def test_every_run_that_differs_from_the_first_of_its_scenario_is_reported() -> None:
    console = quiet()
    assert flakes.lockstep(2 * SCENARIOS, console, by_process) == SCENARIOS
    assert isinstance(console.file, io.StringIO)
    assert console.file.getvalue().count("run ") == SCENARIOS


def test_a_run_that_always_fails_the_same_way_is_reported(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    error = StartError("boat 1: not ready")
    monkeypatch.setattr(flakes, "sail", lambda *_, **__: [error])
    assert flakes.digest_of(("sea", 0)) == "no digest: boat 1: not ready"
    assert flakes.lockstep(2 * SCENARIOS, quiet(), fails) == 2


def test_a_run_that_kills_its_process_is_reported() -> None:
    assert flakes.lockstep(SCENARIOS, quiet(), dies) == 1


def test_a_boats_digest_is_the_same_in_another_run() -> None:
    assert flakes.digest_of(("diamond", 0)) == flakes.digest_of(("diamond", 1))


def test_a_round_in_which_a_command_fails_is_counted(tmp_path: Path) -> None:
    commands = (("true",), ("false",))
    assert flakes.suite(2, tmp_path / "log", quiet(), commands) == 2
    assert flakes.suite(2, tmp_path / "log", quiet(), commands[:1]) == 0
