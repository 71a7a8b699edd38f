# SPDX-License-Identifier: MIT
"""The examples do what their texts say."""

import json
from pathlib import Path

import matplotlib as mpl
import pytest

from sil import ROOT
from sil.cli.main import main

EXAMPLES = ROOT / "sil" / "examples"


def test_scenario_brings_both_boats_to_their_slots(tmp_path: Path) -> None:
    assert main(["run", str(EXAMPLES / "harbour.toml"), "--out", str(tmp_path)]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text(encoding="utf-8"))
    assert [boat["rms_error_m"] < 0.05 for boat in summary["boats"]] == [True, True]
    assert all(boat["states"]["COAST"] > 1.0 for boat in summary["boats"])  # its radio fails


def test_notebook_runs_from_top_to_bottom(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "sil").symlink_to(ROOT / "sil")
    monkeypatch.chdir(tmp_path)
    mpl.use("agg")
    cells = json.loads((EXAMPLES / "trace.ipynb").read_text(encoding="utf-8"))["cells"]
    names: dict[str, object] = {}
    for cell in cells:
        if cell["cell_type"] == "code":
            exec("".join(cell["source"]), names)
    assert "boat 2: " in capsys.readouterr().out
