# SPDX-License-Identifier: MIT
"""The final figures of a campaign, from made-up runs."""

import io
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from sil.campaign import samples, summary
from sil.campaign.finished import columns, read
from sil.campaign.run_outcome import RunResult
from sil.campaign.summary import Effort
from sil.scenario import scenario
from tests.sil.campaign.made_up import Made
from tests.sil.campaign.short import result

FAILED = RunResult(9, 7, "failed", "lost its process")
EFFORT = Effort(wall_s=1.0)


def sailed(
    run: int, levels_m: tuple[float, ...], last_s: int = 200, outcome: str = "ok"
) -> RunResult:
    """A run whose boats are 1000 m off until 99 s and `levels_m` from then on."""
    early = 1000.0 * (np.arange(last_s + 1) < 100)
    return result(run, [(early + m).tolist() for m in levels_m], outcome)


def figures(runs: list[RunResult], duration_s: float = 200.0) -> dict[str, Any]:
    nominal = scenario.load("diamond", [f"duration_s={duration_s}"])
    return dict(summary.figures(nominal, runs, EFFORT, "ab" * 32)["error"])


def test_each_boat_has_its_own_percentiles_of_the_seconds_from_100_s_on() -> None:
    runs = [sailed(run, (1.0 + run, 50.0 - run)) for run in range(20)]
    told = figures(runs)
    assert told["from_s"] == 100.0 and told["runs"] == 20
    assert told["boats"] == [
        {"boat": 1, "p50_m": 10.0, "p95_m": 19.0},
        {"boat": 2, "p50_m": 40.0, "p95_m": 49.0},
    ]


def test_a_diverged_run_counts_as_infinite_and_a_failed_one_not_at_all() -> None:
    told = figures([sailed(0, (1.0,)), sailed(1, (2.0,), outcome="diverged"), FAILED])
    assert told["boats"] == [{"boat": 1, "p50_m": 1.0, "p95_m": np.inf}] and told["runs"] == 2


@pytest.mark.parametrize(("duration_s", "from_s"), [(0.5, 0.0), (2.5, 1.0), (90.0, 45.0)])
def test_a_short_run_is_judged_by_its_second_half(duration_s: float, from_s: float) -> None:
    last_s = int(duration_s)
    values = [float(second) for second in range(last_s + 1)]
    told = figures([result(0, [values])], duration_s)
    late = [value for value in values if value >= from_s]
    median = late[(len(late) - 1) // 2]
    assert told["from_s"] == from_s and told["boats"][0]["p50_m"] == median


def test_the_page_has_the_percentiles_of_the_terminal(tmp_path: Path) -> None:
    campaign = read(Made(runs=12, boats=3, diverged=(4,), failed=(2,)).write(tmp_path))
    table = columns(tmp_path, "seconds")
    runs = []
    for run in campaign.runs[campaign.outcome != "failed"].tolist():
        rows = [table["error_m"][(table["run"] == run) & (table["boat"] == i)] for i in (1, 2, 3)]
        runs.append(result(run, np.array(rows).tolist(), "diverged" if run == 4 else "ok"))
    told = figures(runs, 120.0)
    page = samples.read(campaign)
    levels = [[boat["p50_m"], boat["p95_m"]] for boat in told["boats"]]
    assert page.late_percentiles((50.0, 95.0)).tolist() == levels
    assert page.late_s == told["from_s"] == 60.0


def test_figures_name_the_number_of_failed_runs_that_they_leave_out() -> None:
    console = Console(width=100, file=io.StringIO(), record=True)
    nominal = scenario.load("diamond", ["duration_s=200"])
    for runs in ([sailed(0, (1.0,)), FAILED], [FAILED], [sailed(0, (1.0,))]):
        summary.show(console, nominal, runs, summary.figures(nominal, runs, EFFORT, "ab" * 32))
    said = console.export_text()
    assert "|e| from 100 s on, 1 of 2 runs; 1 failed are not in it" in said
    assert "0 of 1 runs; 1 failed are not in it" in said and "from 100 s on, 1 runs" in said


def test_the_closest_two_boats_and_the_settled_runs_are_reported() -> None:
    nominal = scenario.load("diamond", ["duration_s=200"])
    near = sailed(3, (1.0, 2.0))
    settled = tuple(boat | {"settling_time_s": 30.0} for boat in near.boats)
    half = (settled[0], near.boats[1])
    runs = [
        replace(near, run=1, min_separation_m=2.5, boats=settled),
        replace(near, run=2, min_separation_m=1.7, boats=half),
        replace(near, run=5, min_separation_m=None),
        FAILED,
    ]
    told = summary.figures(nominal, runs, EFFORT, "ab" * 32)
    assert told["closest"] == {"distance_m": 1.7, "run": 2} and told["settled_runs"] == 1
    console = Console(width=100, file=io.StringIO(), record=True)
    summary.show(console, nominal, runs, told)
    said = console.export_text()
    assert "closest two boats: 1.700 m, in run 2" in said
    assert said.startswith(
        "1 of 4 runs settled; in none did two boats come nearer than a hull's length"
    )
    assert summary.figures(nominal, runs[2:], EFFORT, "ab" * 32)["closest"] is None
