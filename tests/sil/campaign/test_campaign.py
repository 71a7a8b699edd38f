# SPDX-License-Identifier: MIT
"""The command `campaign`: equal tables however it is sailed and interrupted."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import psutil
import pyarrow.parquet as pq
import pytest

from sil.campaign import campaign, campaign_report, nominal
from sil.campaign.campaign_files import Folder
from sil.cli.main import main
from sil.lockstep import metrics
from sil.scenario.scenario import load
from tests.each_push import few
from tests.sil.campaign.short import short
from tests.sil.mistakes import assert_told_in_one_line
from tests.turns import some

TABLES = ("table", "draws", "seconds", "envelopes")
RUNS = 7

# A campaign in batches of two whose process gets a signal once it has kept two of them.
INTERRUPTED = """\
import os, signal, sys
from sil.cli.main import main
from sil.campaign import campaign, campaign_files
keep = campaign_files.Folder.keep
def keep_and_stop(folder, result):
    keep(folder, result)
    if len(list(folder.path.glob("parts/*.npz"))) == 2:
        os.kill(os.getpid(), int(sys.argv[1]))
campaign_files.Folder.keep = keep_and_stop
campaign.BATCH = 2
sys.exit(main(sys.argv[2:]))
"""


def command(scenario: Path, out: Path, *more: str) -> list[str]:
    return ["campaign", str(scenario), "--runs", str(RUNS), "--out", str(out), *more]


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return short(tmp_path_factory.mktemp("scenario"))


@pytest.fixture(scope="module")
def sailed(scenario: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of a campaign that nothing disturbed."""
    out = tmp_path_factory.mktemp("campaign") / "out"
    assert main(command(scenario, out, "--workers", "1")) == 0
    assert (out / "report.html").is_file()
    return out


@pytest.fixture(autouse=True)
def _no_pictures(sailed: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Skips the pictures, which have their own tests."""
    monkeypatch.setattr(campaign_report, "write", lambda *_: None)


def assert_same(out: Path, sailed: Path) -> None:
    for name in TABLES:
        assert (out / f"{name}.parquet").read_bytes() == (sailed / f"{name}.parquet").read_bytes()
    digests = [
        json.loads((folder / "campaign.json").read_text())["digest"] for folder in (out, sailed)
    ]
    assert digests[0] == digests[1] and not (out / "parts").exists()


@pytest.mark.parametrize(("workers", "batch"), few([(2, 1), (3, 3)], [(3, 3)]))
def test_tables_do_not_depend_on_workers_and_batches(
    scenario: Path,
    sailed: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    workers: int,
    batch: int,
) -> None:
    monkeypatch.setattr(campaign, "BATCH", batch)
    assert main(command(scenario, tmp_path, "--workers", str(workers))) == 0
    assert_same(tmp_path, sailed)


@pytest.mark.parametrize("varies", [False, True])
def test_identical_runs_are_reported(
    varies: bool, scenario: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short = [str(scenario)] if varies else ["diamond", "--set", "duration_s=2.0"]
    assert main(["campaign", *short, "--runs", "2", "--out", str(tmp_path / "out")]) == 0
    assert ("are identical: see [[vary]]" in capsys.readouterr().out) != varies


def test_a_smaller_campaign_has_the_first_runs_of_a_larger_one(
    scenario: Path, sailed: Path, tmp_path: Path
) -> None:
    assert main(command(scenario, tmp_path, "--runs", "2")) == 0
    few, all_of_them = (pq.read_table(out / "table.parquet") for out in (tmp_path, sailed))
    assert few.equals(all_of_them.slice(0, few.num_rows))


def test_a_run_sailed_alone_has_the_campaigns_figures_bit_for_bit(
    scenario: Path, sailed: Path, tmp_path: Path
) -> None:
    assert main(command(scenario, tmp_path, "--run", "5")) == 0
    rows = [row for row in pq.read_table(sailed / "table.parquet").to_pylist() if row["run"] == 5]
    out = tmp_path / "runs" / "5"
    summary = json.loads((out / "summary.json").read_text(encoding="utf-8"))
    assert (out / "report.html").is_file() and (out / "recording.bin").is_file()
    for row, boat in zip(some(rows), summary["boats"], strict=True):
        for name in ("rms_error_m", "max_error_m", "settling_time_s", "thrust_rms_N"):
            assert row[name] == boat[name]
        assert row["final_psi_rad"] == boat["final_error"]["psi_rad"]
        assert row["s_FORMATION"] == boat["states"]["FORMATION"]
        assert row["min_separation_m"] == summary["min_separation_m"]
        assert row["seed"] == summary["seed"]
    with np.load(out / "trace.npz") as trace:
        distance = metrics.distances(trace["error"])[::100]
    seconds = pq.read_table(sailed / "seconds.parquet", filters=[("run", "=", 5), ("boat", "=", 2)])
    np.testing.assert_array_equal(seconds["error_m"], distance[:, 1].astype(np.float32))


def test_a_run_sailed_again_is_compared_with_its_table(
    scenario: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = command(scenario, tmp_path, "--runs", "2")
    tuned = [*given, "--param", "LAW_KPSI=0.3"]
    assert main(tuned) == 0
    assert main([*tuned, "--run", "1"]) == 0
    assert "run 1: the same motion as in the campaign's table" in capsys.readouterr().out
    for other, said in (
        ([*given, "--run", "1"], "other parameters"),
        ([*tuned, "--run", "1", "--seed", "9"], "other seed"),
        ([*tuned, "--run", "2"], "runs 0 to 1, no run 2"),
    ):
        assert main(other) == 2
        assert said in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "runs").iterdir()] == ["1"]


def test_a_page_that_cannot_be_made_leaves_a_campaign_that_the_same_command_finishes(
    scenario: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*_: object) -> None:
        raise OSError("no space")

    given = command(scenario, tmp_path, "--runs", "2")
    with monkeypatch.context() as patch:
        patch.setattr(campaign_report, "write", fail)
        assert main(given) == 2
    parts = sorted(path.name for path in tmp_path.glob("parts/*.npz"))
    assert parts and main(given) == 0
    assert not (tmp_path / "parts").exists()


@pytest.mark.parametrize("number", few([signal.SIGINT, signal.SIGKILL], [signal.SIGINT]))
def test_an_interrupted_campaign_goes_on_where_it_was(
    scenario: Path,
    sailed: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    number: signal.Signals,
) -> None:
    again = command(scenario, tmp_path, "--workers", "2")
    child = subprocess.run(
        [sys.executable, "-c", INTERRUPTED, str(int(number)), *again],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "CAMPAIGN_TEST": str(tmp_path)},
    )
    if number == signal.SIGINT:
        assert child.returncode == 130 and "to go on: flotilla campaign" in child.stdout
    else:
        assert child.returncode == -signal.SIGKILL
    assert "Traceback" not in child.stderr
    parts = {path.name: path.stat().st_mtime_ns for path in tmp_path.glob("parts/*.npz")}
    assert len(parts) == 2 and not (tmp_path / "table.parquet").exists()
    assert_none_is_left(str(tmp_path))
    seen: dict[str, int] = {}
    finish = Folder.finish

    def look_and_finish(folder: Folder) -> None:
        seen.update({path.name: path.stat().st_mtime_ns for path in tmp_path.glob("parts/*.npz")})
        finish(folder)

    monkeypatch.setattr(Folder, "finish", look_and_finish)
    assert main(again) == 0
    assert parts.items() <= seen.items() and len(seen) > 2
    assert_same(tmp_path, sailed)


def assert_none_is_left(mark: str) -> None:
    """Assert that no process of the campaign remains, except those that are ending."""
    left = []
    for process in psutil.process_iter():
        try:
            if process.environ().get("CAMPAIGN_TEST") == mark:
                left.append(process)
        except psutil.Error:
            continue
    assert psutil.wait_procs(left, timeout=5.0)[1] == []


def test_a_run_stored_twice_is_in_the_tables_once(
    scenario: Path, sailed: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with monkeypatch.context() as unfinished:
        unfinished.setattr(Folder, "finish", lambda folder: None)
        assert main(command(scenario, tmp_path)) == 0
    parts = sorted((tmp_path / "parts").glob("*.npz"))
    (tmp_path / "parts" / "000005.npz").write_bytes(parts[0].read_bytes())
    assert main(command(scenario, tmp_path)) == 0
    assert_same(tmp_path, sailed)


def test_a_folder_in_use_by_another_command_is_refused(
    scenario: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with Folder(tmp_path).alone():
        assert main(command(scenario, tmp_path)) == 2
    assert f"error: another command is at work in {tmp_path}\n" == capsys.readouterr().err
    assert not (tmp_path / "campaign.json").exists()


def test_a_nominal_run_that_fails_costs_no_campaign(
    scenario: Path,
    sailed: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    def write(*_: object) -> bool:
        raise ValueError("cannot convert float NaN to integer")

    monkeypatch.setattr(nominal, "write", write)
    assert main(command(scenario, tmp_path)) == 0
    assert "no nominal run: ValueError: cannot convert float NaN" in capsys.readouterr().out
    assert_same(tmp_path, sailed)


def test_runs_whose_vessels_leave_the_globe_count_as_diverged(
    tmp_path: Path,
) -> None:
    nowhere = "vessel.d22=5000", "duration_s=10", 'leader.navigation.message="global"'
    lost = [item for key in nowhere for item in ("--set", key)]
    given = ["campaign", "leader_global", "--runs", "2", "--out", str(tmp_path)]
    assert main([*given, *lost]) == 0
    told = json.loads((tmp_path / "campaign.json").read_text(encoding="utf-8"))
    assert told["outcomes"] == {"ok": 0, "diverged": 2, "failed": 0}


@pytest.mark.parametrize(
    ("boats", "duration_s", "runs"), [(4, 200.0, 25), (4, 2000.0, 3), (300, 200.0, 1), (1, 0.5, 25)]
)
def test_large_runs_are_sailed_in_small_batches(boats: int, duration_s: float, runs: int) -> None:
    nominal = load("diamond", [f"duration_s={duration_s}"])
    fleet = nominal.model_copy(update={"boat": nominal.boat[:1] * boats})
    assert campaign._most_runs(fleet) == runs


def test_an_unfinished_campaign_is_not_finished_as_another(
    scenario: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "campaign.json").write_text("{}", encoding="utf-8")
    assert main(command(scenario, tmp_path)) == 2
    told = capsys.readouterr().err
    assert "unfinished" in told and "seed: null, now 1" in told and told.count("\n") == 1


def test_a_campaign_leaves_the_results_of_others_alone(
    scenario: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "report.html").write_text("of a run", encoding="utf-8")
    assert main(command(scenario, tmp_path)) == 2
    assert f"{tmp_path} holds files that this command has not made" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--set", "vary.1.normal=[0]"], "must have 2 numbers"),
        (["--set", 'vary.2.key="parameters.LAW_KZ"'], 'no "LAW_KZ"'),
        (["--set", "link.loss=2"], "link.loss"),
        (["--seed", "-1"], "seed -1"),
        (["--param", "LAW_KX"], "NAME=VALUE"),
        (["--param", "THR_ARM=100"], "THR_ARM = 100.0 is out of range"),
        (["--param", "LAW_KX=0.1"], "--param LAW_KX: the scenario varies it"),
    ],
)
def test_a_mistake_is_reported_in_one_line_and_changes_nothing(
    scenario: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], more: list[str], said: str
) -> None:
    out = tmp_path / "out"
    assert main(command(scenario, out, *more)) == 2
    assert_told_in_one_line(said, capsys)
    assert not out.exists()


def test_a_finished_campaign_that_is_replaced_by_another_is_named(
    scenario: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(command(scenario, out)) == 0
    assert main(command(scenario, out)) == 0
    assert "replaces" not in capsys.readouterr().out
    assert main([*command(scenario, out), "--runs", "1"]) == 0
    told = " ".join(capsys.readouterr().out.split())
    assert f"held a finished campaign with runs: {RUNS}, now 1; this one replaces it" in told


def test_a_voyage_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", "voyage", "--runs", "1", "--out", str(tmp_path / "out")]) == 2
    assert_told_in_one_line("voyage: a campaign judges boats by their slots", capsys)
    assert not (tmp_path / "out").exists()


def test_a_failed_run_reports_its_error_when_it_is_replayed(
    scenario: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command(scenario, tmp_path, "--set", "link.loss=1.0", "--run", "3")) == 2
    assert "error: not in the wanted mode" in capsys.readouterr().err


def test_workers_of_another_build_end_the_campaign(
    scenario: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(campaign, "code", lambda: "another")
    assert main(command(scenario, tmp_path, "--workers", "1")) == 2
    assert "error: a worker has another version" in capsys.readouterr().err


def test_runs_that_fail_or_diverge_are_counted_and_the_command_succeeds(
    scenario: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    tiny = "propellers.forward_max_N=0.1", "propellers.reverse_max_N=0.1", "duration_s=120.0"
    lost = [item for key in tiny for item in ("--set", key)]
    # boats that wide have no room beside each other
    refused = ["--set", 'vary.2.key="parameters.THR_ARM"', "--set", "vary.2.uniform=[0.05, 40]"]
    paper = ["--law", "paper"]  # the product's law stops boats that are lost
    assert main(command(scenario, tmp_path, "--runs", "4", *paper, *lost, *refused)) == 0
    told = json.loads((tmp_path / "campaign.json").read_text(encoding="utf-8"))
    rows = pq.read_table(tmp_path / "table.parquet").to_pylist()
    printed = capsys.readouterr().out
    for outcome in ("diverged", "failed"):
        runs = {row["run"] for row in rows if row["outcome"] == outcome}
        assert told["outcomes"][outcome] == len(runs) > 0
        assert f"{len(runs)} of 4 runs {outcome}" in printed
    assert told["error"]["boats"][0]["p95_m"] is None
