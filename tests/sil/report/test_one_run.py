# SPDX-License-Identifier: MIT
"""Sailing one scenario: what it leaves, also when it cannot start or is interrupted."""

import json
from pathlib import Path

import numpy as np
import pytest

from sil.cli.main import main
from sil.live import live_world
from sil.lockstep import metrics
from sil.report import one_run
from sil.view.recorded import history_of_run

EARLIER = ("recording.bin", "boat1/flotillad.log", "boat1/state/parameters", "boat1/log/x.tlog")


def summary() -> metrics.Summary:
    return {
        "scenario": "diamond",
        "seed": 1,
        "duration_s": 1.0,
        "wall_s": 1.0,
        "real_time_factor": 1.0,
        "digest": None,
        "release_unix_s": None,
        "late_s": None,
        "boats": [],
        "min_separation_m": None,
        "hull_m": 1.0,
    }


def test_interrupt_while_the_trace_is_written_leaves_the_earlier_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    one_run.save(tmp_path, summary(), {"t_s": np.zeros(3)})

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(np.lib.format, "write_array", interrupt)
    with pytest.raises(KeyboardInterrupt):
        one_run.save(tmp_path, summary(), {"t_s": np.ones(3)})
    assert {path.name for path in tmp_path.iterdir()} == {"summary.json", "trace.npz"}
    with np.load(tmp_path / "trace.npz") as trace:
        assert np.array_equal(trace["t_s"], np.zeros(3))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (["--bus", "mcats:0"], '--bus "mcats:0"'),
        (["--mavlink", "udp:1"], "udp:1"),
        (["--gcs", "127.0.0.1:14550"], "--gcs"),
        (["--param", "LAW_KX=9"], "LAW_KX"),
    ],
)
def test_live_run_that_cannot_start_builds_nothing_and_keeps_earlier_logs(
    wrong: list[str],
    said: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(live_world, "build", lambda _: pytest.fail("built"))
    for name in EARLIER:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes(b"earlier")
    assert main(["live", "diamond", *wrong, "--out", str(tmp_path)]) == 2
    assert said in capsys.readouterr().err
    assert all((tmp_path / name).exists() for name in EARLIER)


def test_brackets_in_names_are_printed_as_they_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "[a]"
    named = ("--set", "duration_s=2", "--set", 'name="[b]"')
    main(["run", "diamond", *named, "--mcap", "--out", str(out)])
    told = capsys.readouterr().out
    assert f"results: {out}/report.html" in told and f"log: {out}/run.mcap" in told
    assert "[b]: sailing 2 s" in told and "[b], seed 1" in told


def test_a_voyage_leaves_no_figures_of_a_formation(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "errors.png").write_bytes(b"of an earlier run")
    (tmp_path / "summary.json").write_text('{"scenario": "voyage"}')
    assert main(["run", "voyage", "--set", "duration_s=5", "--out", str(tmp_path)]) == 0
    assert "the voyage was not over after 5 s" in capsys.readouterr().out
    assert (tmp_path / "formation.png").exists() and not (tmp_path / "errors.png").exists()
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.count("<td>–</td>") == 5
    boat = history_of_run(tmp_path)["vessels"][1]
    assert "x_m" in boat and not {"slot_x_m", "error_m", "in_slot"} & boat.keys()
    assert "&quot;x_m&quot;:&quot;" in page and "&quot;error_m&quot;:&quot;" not in page


def test_errors_of_a_leading_fleet_are_judged_until_its_plan_is_over(tmp_path: Path) -> None:
    short = ["duration_s=60.0", "leader.waypoints=[[0, 0], [12, 0]]"]
    named = [word for value in short for word in ("--set", value)]
    assert main(["run", "lead", *named, "--out", str(tmp_path)]) == 0
    told = json.loads((tmp_path / "summary.json").read_text())
    plan = told["plan"]
    assert (plan["item"], plan["items"]) == (2, 2) and 20.0 < plan["over_s"] < 50.0
    with np.load(tmp_path / "trace.npz") as trace:
        off_m, late = metrics.distances(trace["error"]), trace["t_s"] > plan["over_s"]
    assert plan["waiting_m"] == off_m[late].max()
    for boat, own in zip(told["boats"], off_m[~late].T, strict=True):
        assert boat["max_error_m"] == own[2 * len(own) // 3 + 1 :].max()
