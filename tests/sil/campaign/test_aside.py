# SPDX-License-Identifier: MIT
"""The nominal run in parallel with a campaign: it delays nothing and ends with it."""

import itertools
from collections.abc import Callable
from pathlib import Path

import pytest

from sil.campaign import nominal
from sil.campaign.aside import nominal_run
from sil.lockstep.world import Progress
from sil.scenario import scenario

CALM = scenario.load("diamond", ["duration_s=1"])


def test_nominal_run_is_finished_with_the_campaign(tmp_path: Path) -> None:
    said: list[str] = []
    with nominal_run(tmp_path, CALM, {"LAW_KX": 0.3}, said.append):
        pass
    assert nominal.read(tmp_path) is not None and said == []


def test_failed_nominal_run_is_reported_and_stops_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write(*_: object) -> bool:
        raise ZeroDivisionError("of the nominal run")

    monkeypatch.setattr(nominal, "write", write)
    said: list[str] = []
    with nominal_run(tmp_path, CALM, {}, said.append):
        pass
    assert said == ["no nominal run: ZeroDivisionError: of the nominal run"]


def test_an_interrupted_campaign_ends_its_nominal_run(tmp_path: Path) -> None:
    def interrupted(say: Callable[[str], object]) -> None:
        with nominal_run(tmp_path, CALM.model_copy(update={"duration_s": 1e4}), {}, say):
            raise KeyboardInterrupt

    said: list[str] = []
    with pytest.raises(KeyboardInterrupt):
        interrupted(said.append)
    assert said == [] and nominal.read(tmp_path) is None


def test_nominal_run_reports_its_progress(tmp_path: Path) -> None:
    shares: list[float] = []
    progress: Progress = shares.append
    assert nominal.write(tmp_path, CALM, {}, progress)
    assert shares[0] == 0.0 and shares[-1] == 1.0
    assert all(a < b for a, b in itertools.pairwise(shares))
