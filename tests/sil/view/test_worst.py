# SPDX-License-Identifier: MIT
"""The worst run of a campaign, sailed again."""

from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from sil.__main__ import main
from sil.campaign import finished, replay
from sil.view.history import numbers
from sil.view.worst import history_of_worst, worst_run
from tests.sil.campaign.made_up import Made
from tests.sil.campaign.short import short

QUIET = Console(quiet=True)


def test_the_worst_run_is_that_of_the_report(tmp_path: Path) -> None:
    campaign = finished.read(Made(runs=20, diverged=(3,), failed=(5,)).write(tmp_path))
    run = worst_run(campaign)
    error_m = campaign.worst("error_p95_m")
    error_m[[3, 5]] = 0.0
    assert run == error_m.argmax()


def test_where_no_run_ended_well_the_first_that_did_not_is_shown(tmp_path: Path) -> None:
    made = Made(runs=3, diverged=(1, 2), failed=(0,)).write(tmp_path)
    assert worst_run(finished.read(made)) == 0


def test_the_worst_run_is_sailed_again_as_the_campaign_sailed_it(tmp_path: Path) -> None:
    out = tmp_path / "campaign"
    arguments = ["campaign", str(short(tmp_path)), "--runs", "4", "--workers", "1"]
    assert main([*arguments, "--seed", "9", "--param", "LAW_XT_DIST=2", "--out", str(out)]) == 0
    (tmp_path / "short.toml").unlink()
    history = history_of_worst(out, QUIET)
    campaign = finished.read(out)
    run = worst_run(campaign)
    assert replay.is_same(campaign, run)
    assert history["title"] == f"short, run {run}, the worst of 4"
    with np.load(replay.place(out, run) / "trace.npz") as trace:
        x_m = numbers(history["vessels"][1]["x_m"])
        assert x_m[-1] == pytest.approx(trace["eta"][-1, 1, 0], rel=1e-6)
    assert history["vessels"][1]["states"] == [[0.0, "FORMATION"]]

    recording = replay.place(out, run) / "recording.bin"
    written = recording.stat().st_mtime_ns
    assert history_of_worst(out, QUIET) == history
    assert recording.stat().st_mtime_ns == written


def test_a_folder_without_a_finished_campaign_is_told(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no campaign in"):
        history_of_worst(tmp_path, QUIET)
