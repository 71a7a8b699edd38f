# SPDX-License-Identifier: MIT
"""The worst run of a campaign, which its report replays."""

import re
from html import unescape
from pathlib import Path

import numpy as np
import pytest

from sil.campaign import campaign_report, finished, page_tables, worst
from sil.cli.main import main
from sil.lockstep import metrics
from sil.lockstep.start import StartError
from sil.lockstep.world import sail
from sil.view import history
from tests.sil.campaign.made_up import Made
from tests.sil.campaign.short import sampler, short
from tests.turns import some


@pytest.fixture(scope="module")
def sailed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("campaign")
    out = folder / "out"
    given = ["campaign", str(short(folder)), "--runs", "4", "--workers", "1", "--out", str(out)]
    assert main(given) == 0
    return out


def test_worst_run_is_replayed_as_it_was_sailed(sailed: Path) -> None:
    told = worst.read(sailed)
    number = page_tables.worst(finished.read(sailed))[0][0]
    (run,) = sail([sampler(sailed.parent).scenario(number)], {})
    assert told is not None and not isinstance(run, StartError)
    assert told["title"] == f"short, run {number}, the worst of 4"
    distance = metrics.distances(run.trace["error"])
    assert history.numbers(told["t_s"]) == pytest.approx(run.trace["t_s"], abs=1e-6)
    for i, boat in enumerate(some(told["vessels"][1:])):
        assert boat["id"] == i + 1
        assert boat["states"] == [[0.0, "FORMATION"]]
        assert history.numbers(boat["error_m"]) == pytest.approx(distance[:, i], rel=1e-6)


def test_report_carries_the_worst_run(sailed: Path) -> None:
    text = (sailed / "report.html").read_text(encoding="utf-8")
    (inner,) = re.findall(r'srcdoc="([^"]*)"', text)
    told = worst.read(sailed)
    assert told is not None and f"<title>{told['title']}</title>" in unescape(inner)


def test_campaign_with_only_diverged_runs_has_no_worst_run_to_replay(tmp_path: Path) -> None:
    chosen = sampler(tmp_path)
    folder = Made(runs=3, diverged=(0, 1, 2)).write(tmp_path / "lost")
    np.savez(folder / "nominal.npz", t_s=[0.0], eta=np.zeros((1, 5, 3)), error=np.ones((1, 4, 3)))
    (folder / worst.NAME).write_bytes(b"of another campaign")
    assert not worst.write(folder, chosen, {})
    assert worst.read(folder) is None
    campaign_report.write(folder)
    assert "<p>None was sailed again.</p>" in (folder / "report.html").read_text(encoding="utf-8")


def test_worst_run_that_cannot_be_started_here_is_left_out(tmp_path: Path) -> None:
    folder = Made(runs=3).write(tmp_path / "made")
    assert not worst.write(folder, sampler(tmp_path), {"LAW_KX": 99.0})
    assert worst.read(folder) is None


def test_damaged_history_is_reported_with_its_file(tmp_path: Path) -> None:
    (tmp_path / worst.NAME).write_bytes(b'{"title": ')
    with pytest.raises(ValueError, match=r"worst\.json is damaged"):
        worst.read(tmp_path)
