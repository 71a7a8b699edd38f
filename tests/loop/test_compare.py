# SPDX-License-Identifier: MIT
"""Compares really sailed campaigns, as CI does: is one worse than the other?"""

from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from sil.campaign import campaign_report
from sil.cli.main import main

CHANGES = {
    "as it is": [],
    "another seed": ["--seed", "2"],
    "gain lower": ["--param", "LAW_KX=0.16"],
}
# Each push compares made-up campaigns: tests/sil/campaign/test_compare.py.
pytestmark = pytest.mark.nightly
Sailed = Callable[[str], Path]


@pytest.fixture(scope="module")
def sailed(tmp_path_factory: pytest.TempPathFactory) -> Sailed:
    """Campaigns of the paper's law by their change, each sailed when it is first asked for."""
    folder = tmp_path_factory.mktemp("campaigns")

    @cache
    def sail(name: str) -> Path:
        size = ["--runs", "24", "--workers", "2", "--set", "duration_s=80"]
        out = ["--out", str(folder / name)]
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(campaign_report, "write", lambda *_: None)  # pictures have own tests
            assert main(["campaign", "paper_monte_carlo", *size, *CHANGES[name], *out]) == 0
        return folder / name

    return sail


def compare(sailed: Sailed, a: str, b: str) -> int:
    return main(["compare", str(sailed(a)), str(sailed(b))])


def test_gain_that_is_20_percent_lower_is_found_to_be_worse(
    sailed: Sailed, capsys: pytest.CaptureFixture[str]
) -> None:
    assert compare(sailed, "as it is", "gain lower") == 1
    assert "B is worse: rms_error_m" in capsys.readouterr().out


def test_gain_that_is_put_back_is_found_to_be_better(
    sailed: Sailed, capsys: pytest.CaptureFixture[str]
) -> None:
    assert compare(sailed, "gain lower", "as it is") == 0
    assert "B is better: rms_error_m" in capsys.readouterr().out


def test_same_code_with_another_seed_is_no_worse_and_no_better(
    sailed: Sailed, capsys: pytest.CaptureFixture[str]
) -> None:
    assert compare(sailed, "as it is", "another seed") == 0
    assert "no change that is certain" in capsys.readouterr().out
