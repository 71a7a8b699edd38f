# SPDX-License-Identifier: MIT
"""The command `results`: runs, files and exit status, with made-up outcomes."""

import argparse
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sil.campaign import finished
from sil.cli import results_command
from sil.report import comparison
from sil.results import published, results, results_campaigns, results_fleets, results_readme
from sil.results.claims import CLAIMS, LAWS
from sil.results.results_table import BEGIN, END
from sil.results.sailing import Job, Outcome
from sil.scenario import scenario
from tests.sil.campaign.made_up import Made

Tell = Callable[[Outcome], None]
PAGE = f"before\n{BEGIN}{END}\nbetween\n{results_campaigns.BEGIN}{END}\nafter\n"
MEASUREMENTS = f"{results_readme.MEASURED_BEGIN}{END}\n{results_readme.LAW_BEGIN}{END}\n"
NAMES = {"RESULTS.md", "MEASUREMENTS.md"}


def options(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    results_command.add_to(parser)
    return parser.parse_args(arguments)


def fleet(job: Job, **changed: float) -> Outcome:
    """An outcome that meets every bound, except with the changed figures."""
    t_s = np.arange(0.0, 301.0)
    keys = [bound.key for bound in CLAIMS[job.scenario].bounds]
    good = 0.0001 if job.law == "product" else 0.029
    figures = {key: 1.0 if key == "least_separation_m" else good for key in keys}
    trace = {"t_s": t_s, "eta": np.ones((301, 2, 3)), "error": np.ones((301, 1, 3))}
    return Outcome(job, figures={**figures, **changed}, trace=trace)


@pytest.fixture
def sail(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., list[Job]]:
    """Makes the command use made-up outcomes in a temporary folder; collects its jobs."""

    def sail(outcome_of: Callable[[Job], Outcome]) -> list[Job]:
        jobs: list[Job] = []

        def sail_all(given: Sequence[Job], workers: int, tell: Tell) -> list[Outcome]:
            jobs.extend(given)
            outcomes = [outcome_of(job) for job in given]
            for outcome in outcomes:
                tell(outcome)
            return outcomes

        monkeypatch.setattr(results, "sail_all", sail_all)
        return jobs

    for name, text in (("PAGE", PAGE), ("MEASUREMENTS", MEASUREMENTS)):
        path = tmp_path / getattr(published, name).name
        path.write_text(text, encoding="utf-8")
        monkeypatch.setattr(published, name, path)
    monkeypatch.setattr(published, "FIGURES", tmp_path / "results" / "figures.json")
    monkeypatch.setattr(results_readme, "sail", lambda: dict(results_readme.WANTED))
    monkeypatch.setattr(comparison, "png", lambda figure: b"picture")
    names = results_campaigns.NAMES.values()
    campaigns = [
        Made(boats=1, scenario=name).write(tmp_path / f"campaign_{name}") for name in names
    ]
    found = [finished.read(folder) for folder in campaigns]
    monkeypatch.setattr(results_campaigns, "sail", lambda out, workers: found)
    monkeypatch.setattr(results, "PICTURES", tmp_path / "results")
    monkeypatch.chdir(tmp_path)
    return sail


def files(folder: Path) -> set[str]:
    found = (str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file())
    return {name for name in found if not name.startswith("campaign_")}


def test_whole_run_sails_every_scenario_with_both_laws_and_mismatch_with_40_seeds(
    sail: Callable[..., list[Job]],
) -> None:
    jobs = sail(fleet)
    assert results.main(options()) == 0
    names = [name for name in CLAIMS if name != "mismatch"]
    assert len(jobs) == len(set(jobs)) == 2 * (len(names) + 40)
    assert {job[:3] for job in jobs if job.seed is None} == {
        (name, law, None) for name in names for law in LAWS
    }
    assert sorted(job.seed or 0 for job in jobs if job.law == "paper")[-40:] == [*range(1, 41)]


def test_whole_run_writes_page_and_pictures_and_is_repeatable(
    sail: Callable[..., list[Job]], tmp_path: Path
) -> None:
    sail(fleet)
    results.main(options())
    campaigns = results_campaigns.NAMES.values()
    assert files(tmp_path) == {
        *NAMES,
        "out/results/results.json",
        "results/figures.json",
        *(f"results/{name}.png" for name in (*CLAIMS, *campaigns)),
        *(f"out/results/{name}.png" for name in CLAIMS),
    }
    page = (tmp_path / "RESULTS.md").read_text(encoding="utf-8")
    assert page.startswith("before\n") and page.endswith("\nafter\n") and "**NO**" not in page
    assert published.pages(published.noted()) == {
        path: path.read_text(encoding="utf-8") for path in (published.PAGE, published.MEASUREMENTS)
    }
    once = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    results.main(options())
    assert {path: path.read_bytes() for path in once} == once


@pytest.mark.parametrize("few", [["--only", "sea"], ["--seeds", "2"], ["--set", "duration_s=9"]])
def test_a_run_of_fewer_scenarios_leaves_the_page_alone(
    sail: Callable[..., list[Job]], tmp_path: Path, few: list[str]
) -> None:
    jobs = sail(fleet)
    assert results.main(options(*few, "--out", "here")) == 0
    assert (tmp_path / "RESULTS.md").read_text(encoding="utf-8") == PAGE
    assert {name.partition("/")[0] for name in files(tmp_path)} == {*NAMES, "here"}
    if few[0] == "--only":
        assert jobs == [Job("sea", law) for law in LAWS]


@pytest.mark.parametrize(("worse", "status"), [(1.09, 0), (1.11, 1)])
def test_other_scalar_is_sailed_beside_float_and_nothing_is_written(
    sail: Callable[..., list[Job]], tmp_path: Path, worse: float, status: int
) -> None:
    def outcome(job: Job) -> Outcome:
        return fleet(job, rms_error_m=worse if "scalar='q16'" in job.overrides else 1.0)

    jobs = sail(outcome)
    few = ("--only", "sea", "--set", "duration_s=9")
    assert results.main(options(*few, "--scalar", "q16")) == status
    assert jobs == [
        Job("sea", law, None, ("duration_s=9", f"scalar='{scalar}'"))
        for scalar in ("float", "q16")
        for law in LAWS
    ]
    assert files(tmp_path) == NAMES


def test_missed_bound_or_failed_run_ends_with_status_1_and_the_rest_is_written(
    sail: Callable[..., list[Job]], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def missed(job: Job) -> Outcome:
        return fleet(job, rms_error_m=math.inf if job == ("sea", "product", None, ()) else 0.0)

    def failed(job: Job) -> Outcome:
        return Outcome(job, "hit a [pier]") if job[:2] == ("noisy", "product") else fleet(job)

    few = ("--only", "noisy", "--only", "sea")
    sail(missed)
    assert results.main(options(*few)) == 1
    sail(failed)
    assert results.main(options(*few)) == 1
    assert "noisy, product: hit a [pier]" in capsys.readouterr().out
    text = (tmp_path / "out/results/results.json").read_text(encoding="utf-8")
    runs = {(run["scenario"], run["law"]): run for run in json.loads(text)["runs"]}
    assert runs["noisy", "product"]["failure"] == "hit a [pier]"
    assert runs["sea", "product"]["figures"] == {"rms_error_m": 0.0001}


def test_json_has_null_for_never(sail: Callable[..., list[Job]], tmp_path: Path) -> None:
    sail(lambda job: fleet(job, settling_s=math.inf))
    assert results.main(options("--only", "diamond")) == 1
    text = (tmp_path / "out/results/results.json").read_text(encoding="utf-8")
    bounds = {bound["figure"]: bound for bound in json.loads(text)["bounds"]}
    assert bounds["settling_s"] == {
        "scenario": "diamond",
        "figure": "settling_s",
        "paper": None,
        "product": None,
        "to_reach": "1.5 × sooner",
        "reached": False,
    }
    assert bounds["deviation_from_reference"]["paper"] == 0.029


def test_an_interrupted_run_writes_nothing(sail: Callable[..., list[Job]], tmp_path: Path) -> None:
    def interrupted(job: Job) -> Outcome:
        raise KeyboardInterrupt

    sail(interrupted)
    assert results.main(options()) == 130
    assert files(tmp_path) == NAMES


@pytest.mark.parametrize("page", sorted(NAMES))
def test_a_file_that_cannot_be_written_is_reported_before_anything_is_sailed(
    sail: Callable[..., list[Job]], tmp_path: Path, capsys: pytest.CaptureFixture[str], page: str
) -> None:
    jobs = sail(fleet)
    (tmp_path / page).write_text("no marks", encoding="utf-8")
    assert results.main(options()) == 2
    assert results.main(options("--only", "sea", "--out", "RESULTS.md")) == 2
    errors = capsys.readouterr().err.splitlines()
    assert len(errors) == 2 and all(error.startswith("error: ") for error in errors)
    assert jobs == []


@pytest.mark.parametrize(
    "arguments",
    [["--seeds", "0"], ["--workers", "-1"], ["--scalar", "float"]],
)
def test_invalid_options_are_refused(arguments: list[str]) -> None:
    with pytest.raises(SystemExit, match="2"):
        options(*arguments)


def test_a_scenario_that_is_not_published_is_refused() -> None:
    with pytest.raises(ValueError, match="--only dimond: there are diamond"):
        results.main(options("--only", "dimond"))


@pytest.mark.parametrize("name", CLAIMS)
def test_every_scenario_of_the_table_is_there_and_takes_300_s(name: str) -> None:
    assert scenario.load(name).duration_s == 300.0
    for law in LAWS:
        assert scenario.load(name, [], law).law == law


def test_fleets_are_judged_and_renew_their_table_and_no_other(
    sail: Callable[..., list[Job]],
    monkeypatch: pytest.MonkeyPatch,
    tmp_path: Path,
) -> None:
    late: Any = {"rms_error_m": 0.25, "states": {"FORMATION": 290.0, "HOLD": 10.0}}
    figures_m = {"line10": 0.25}

    def outcome(job: Job) -> Outcome:
        off_m = figures_m.get(job.scenario, 0.01)
        return replace(fleet(job, rms_error_m=off_m), boats=[late], trace={})

    place = tmp_path / "RESULTS.md"
    place.write_text(f"before\n{results_fleets.BEGIN}{END}\nafter\n", encoding="utf-8")
    monkeypatch.setattr(results_fleets, "PAGE", place)
    monkeypatch.setattr(results_fleets, "FIGURES", tmp_path / "fleets.json")
    jobs = sail(outcome)
    assert results.main(options("--fleets")) == 1
    assert jobs == results_fleets.jobs() and len(jobs) == len(set(jobs))
    assert files(tmp_path) == {*NAMES, "fleets.json"}
    text = place.read_text(encoding="utf-8")
    assert text.startswith("before\n") and text.endswith("\nafter\n")
    missed = "RMS distance from the slot, last third | 0.250 m | 0.1 m | **NO** |"
    assert f"| 10 relayed only, 0.1 s, 10 % lost a hop | {missed}" in text
    assert text.count("**NO**") == 1
    assert "RMS distance by depth, m: 0.250." in text
    assert "the mean boat was in FORMATION 290.0 s, HOLD 10.0 s" in text
    assert results_fleets.page(results_fleets.noted()) == text
    figures_m.clear()
    assert results.main(options("--fleets")) == 0


@pytest.mark.parametrize("case", results_fleets.CASES, ids=lambda case: case.about)
def test_case_of_fleets_is_a_scenario_that_can_be_sailed(case: results_fleets.Case) -> None:
    settings = CLAIMS[case.scenario].settings("product")
    chosen = scenario.load(case.scenario, [*settings, *case.overrides], "product")
    assert chosen.duration_s >= 150.0  # figures count from 100 s on
    assert len(chosen.boat) in (4, 10, 20)
