# SPDX-License-Identifier: MIT
"""Campaigns on a Dask cluster: equal to local ones, even if a worker dies."""

import os
import signal
from collections.abc import Iterator
from pathlib import Path

import dask
import distributed
import pytest

from sil.campaign import campaign, campaign_report, runner
from sil.campaign.campaign_files import Folder
from sil.campaign.sampling import Sampler
from sil.campaign.work import Share, ShareResult, sail_batch
from sil.cli.main import main
from sil.lockstep.world import sail
from sil.scenario import scenario
from sil.scenario.scenario import Scenario
from tests.sil.campaign.short import batch, sampler, short

TABLES = ("table", "draws", "seconds", "envelopes")


class Fatal(Sampler):
    """A sampler that kills the process that is to sail run 1, once that has sailed something.

    Dask does not start a worker again that ends while it starts.
    """

    def scenario(self, run: int) -> Scenario:
        if run == 1:
            sail([super().scenario(0)], {})
            os._exit(9)
        return super().scenario(run)


@pytest.fixture(scope="module")
def cluster() -> Iterator[distributed.LocalCluster]:
    """Two worker processes; a task that kills two workers is given up."""
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 1}),
        distributed.LocalCluster(
            n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0"
        ) as cluster,
    ):
        yield cluster


def test_a_cluster_that_loses_a_worker_makes_the_same_tables(
    cluster: distributed.LocalCluster, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(campaign_report, "write", lambda *_: None)
    given = ["campaign", str(short(tmp_path)), "--runs", "12", "--set", "duration_s=30.0"]
    assert main([*given, "--out", str(tmp_path / "here")]) == 0
    killed: list[int] = []
    keep = Folder.keep

    def keep_and_kill(folder: Folder, result: ShareResult) -> None:
        keep(folder, result)
        if not killed:
            killed.append(cluster.workers[0].pid)
            os.kill(killed[0], signal.SIGKILL)

    monkeypatch.setattr(Folder, "keep", keep_and_kill)
    monkeypatch.setattr(campaign, "BATCH", 1)
    there = ["--out", str(tmp_path / "there"), "--scheduler", cluster.scheduler_address]
    assert main([*given, *there]) == 0
    assert killed and cluster.workers[0].pid != killed[0]
    for name in TABLES:
        files = [tmp_path / place / f"{name}.parquet" for place in ("here", "there")]
        assert files[0].read_bytes() == files[1].read_bytes()


@pytest.mark.nightly
def test_a_run_that_kills_every_worker_has_failed_and_costs_no_other(
    cluster: distributed.LocalCluster, tmp_path: Path
) -> None:
    fatal = batch(Fatal(scenario.read(short(tmp_path))), (0, 1, 2))
    noted: list[ShareResult] = []
    runner.on_cluster(lambda threads: [fatal], cluster.scheduler_address, noted.append)
    assert_failed_alone(sampler(tmp_path), noted)


@pytest.mark.nightly  # each push: tests/sil/common/test_pool.py
def test_a_run_that_kills_its_process_has_failed_and_costs_no_other(tmp_path: Path) -> None:
    fatal = batch(Fatal(scenario.read(short(tmp_path))), (0, 1, 2))
    noted: list[ShareResult] = []
    runner.locally([fatal, batch(sampler(tmp_path), (3,))], 2, noted.append)
    assert noted.pop(0).runs[0].run == 3
    assert_failed_alone(sampler(tmp_path), noted)


def assert_failed_alone(made: Sampler, noted: list[ShareResult]) -> None:
    runs = sorted((run for result in noted for run in result.runs), key=lambda run: run.run)
    assert [run.outcome for run in runs] == ["ok", "failed", "ok"]
    assert runs[1].reason == "the process died" and runs[1].seed == made.seed_of(1)
    for run in (runs[0], runs[2]):
        assert run.digest == sail_batch(batch(made, (run.run,))).runs[0].digest


def test_missing_scheduler_is_reported_with_its_address(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    given = ["campaign", str(short(tmp_path)), "--out", str(tmp_path / "out")]
    with dask.config.set({"distributed.comm.timeouts.connect": "200ms"}):
        assert main([*given, "--scheduler", "tcp://127.0.0.1:9"]) == 2
    assert "tcp://127.0.0.1:9" in capsys.readouterr().err


def test_workers_that_are_not_there_yet_are_waited_for(tmp_path: Path) -> None:
    few: list[int] = []
    said: list[str] = []
    noted: list[ShareResult] = []
    with distributed.LocalCluster(
        n_workers=0, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    ) as late:

        def say(text: str) -> None:
            said.append(text)
            late.scale(1)

        def batches(least: int) -> list[Share]:
            few.append(least)
            return [batch(sampler(tmp_path), (0,))]

        assert runner.on_cluster(batches, late.scheduler_address, noted.append, say) == 1
    assert few == [4] and len(noted) == 1
    assert said == [f"{late.scheduler_address} has no workers: waiting for the first"]


def test_a_lost_scheduler_is_reported_with_its_address(tmp_path: Path) -> None:
    made = sampler(tmp_path, "", ("duration_s=20.0",))
    with distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, host="127.0.0.1", dashboard_address="127.0.0.1:0"
    ) as ended:
        address = ended.scheduler_address

        def note(_: ShareResult) -> None:
            ended.close()

        with pytest.raises(OSError, match=address):
            runner.on_cluster(
                lambda least: [batch(made, (run,)) for run in range(8)], address, note
            )
