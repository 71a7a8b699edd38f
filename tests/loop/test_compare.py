# SPDX-License-Identifier: MIT
"""Compares really sailed campaigns, as CI does: is one worse than the other?"""

from pathlib import Path

import pytest

from sil.campaign import campaign_report
from sil.cli.main import main


@pytest.fixture(scope="module")
def sailed(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Campaigns of the paper's law: as it is, with another seed, with a gain 20 % lower."""
    folder = tmp_path_factory.mktemp("campaigns")
    changes = {
        "as it is": [],
        "another seed": ["--seed", "2"],
        "gain lower": ["--param", "LAW_KX=0.16"],
    }
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(campaign_report, "write", lambda *_: None)  # pictures have tests of their own
        for name, change in changes.items():
            size = ["--runs", "24", "--workers", "2", "--set", "duration_s=80"]
            out = ["--out", str(folder / name)]
            assert main(["campaign", "paper_monte_carlo", *size, *change, *out]) == 0
    return {name: folder / name for name in changes}


def compare(sailed: dict[str, Path], a: str, b: str) -> int:
    return main(["compare", str(sailed[a]), str(sailed[b])])


def test_gain_that_is_20_percent_lower_is_found_to_be_worse(
    sailed: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert compare(sailed, "as it is", "gain lower") == 1
    assert "B is worse: rms_error_m" in capsys.readouterr().out


def test_gain_that_is_put_back_is_found_to_be_better(
    sailed: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert compare(sailed, "gain lower", "as it is") == 0
    assert "B is better: rms_error_m" in capsys.readouterr().out


def test_same_code_with_another_seed_is_no_worse_and_no_better(
    sailed: dict[str, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert compare(sailed, "as it is", "another seed") == 0
    assert "no change that is certain" in capsys.readouterr().out
