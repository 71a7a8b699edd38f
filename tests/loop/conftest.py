# SPDX-License-Identifier: MIT
"""Runs of whole scenarios, shared by the tests of the closed loop."""

from collections.abc import Callable
from pathlib import Path

import pytest

from sil.lockstep.world import Run, World
from sil.scenario import scenario

Sail = Callable[..., Run]


@pytest.fixture
def sail(tmp_path: Path) -> Sail:
    """Sails a scenario; its recording stays in the test's folder for tools/replay."""

    def sail(name: str | Path, *overrides: str, parameters: dict[str, float] | None = None) -> Run:
        world = World(scenario.load(name, overrides), parameters or {})
        return world.run(tmp_path / "recording.bin", lambda _: None)

    return sail


@pytest.fixture(scope="session")
def diamond(tmp_path_factory: pytest.TempPathFactory) -> tuple[Run, Path]:
    """The whole of `diamond`, once for all tests: the run and its recording."""
    recording = tmp_path_factory.mktemp("diamond") / "recording.bin"
    return World(scenario.load("diamond"), {}).run(recording, lambda _: None), recording
