# SPDX-License-Identifier: MIT
"""The report of a made-up run of two boats, one of which never settles."""

import io
import json
import re
from html import unescape
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from sil.lockstep import metrics
from sil.lockstep.metrics import Summary
from sil.plant.hull import Array
from sil.report import one_run, plots, run_report
from sil.report.drawing import draw
from sil.scenario.sections import Leader
from sil.view import history
from sil.view import page as view
from tests.each_push import few

PICTURES = ("formation.png", "errors.png", "thrust.png")
COMMAND = "flotilla run pair --seed 7 --set 'boat.1.eta=[0, 0, 0]'"


def made_up_run(ticks: int = 2001) -> tuple[Summary, dict[str, Array]]:
    t_s: Array = 0.01 * np.arange(ticks, dtype=np.float64)
    still = np.zeros_like(t_s)
    leader = np.stack([t_s, np.sin(t_s), still], axis=-1)
    closing = np.stack([2.0 * np.exp(-t_s), still, still], axis=-1)
    offset_m = np.array([[0.0, 0.0], [-3.0, 0.0]])
    away = np.array([0.0, 1.0, 0.0])
    eta = np.stack([leader, leader + closing, leader + closing + [-3, 0, 0] + away], axis=1)
    error = metrics.formation_error(eta, [0, 1], offset_m)
    thrust = np.tile([1.0, -0.5], (ticks, 2, 1))
    states = [{"FORMATION": 20.0, "FAULT": 0.0}, {"FORMATION": 18.5, "FAULT": 1.5}]
    summary: Summary = {
        "scenario": "pair & co",
        "seed": 7,
        "duration_s": 20.0,
        "wall_s": 0.5,
        "release_unix_s": 0.0,
        "late_s": 0.0,
        "real_time_factor": 40.0,
        "digest": "ab" * 32,
        "boats": metrics.boats(t_s, error, thrust, states),
        "min_separation_m": metrics.min_separation_m(eta),
        "hull_m": 1.0,
    }
    trace = {"t_s": t_s, "eta": eta, "nu": 0.0 * eta, "error": error, "thrust": thrust}
    return summary, trace


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("run")
    summary, trace = made_up_run()
    run_report.write(path, summary, trace, COMMAND, draw("pair", trace))
    return path


def test_run_leaves_its_pictures_and_page_and_nothing_half_written(folder: Path) -> None:
    assert {file.name for file in folder.iterdir()} == {*PICTURES, "report.html"}
    for name in PICTURES:
        assert (folder / name).read_bytes().startswith(b"\x89PNG")


def test_page_carries_its_pictures_and_needs_no_other_file(folder: Path) -> None:
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert page.count('src="data:image/png;base64,') == len(PICTURES)
    assert not re.search(r"(src|href)=\"(?!data:)", page)
    assert 'name="viewport"' in page


def test_page_carries_the_replay_of_the_run(folder: Path) -> None:
    text = (folder / "report.html").read_text(encoding="utf-8")
    (inner,) = re.findall(r'srcdoc="([^"]*)"', text)
    (told,) = re.findall(r'id="history">(.*?)</script>', unescape(inner))
    replay = json.loads(told)
    assert replay["title"] == "pair & co, seed 7"
    assert [vessel["kind"] for vessel in replay["vessels"]] == ["leader", "boat", "boat"]
    shown = history.numbers(replay["vessels"][2]["error_m"])
    trace = made_up_run()[1]
    wanted = metrics.distances(trace["error"][history.kept(trace["t_s"].size), 1])
    assert shown == pytest.approx(wanted, abs=1e-5)


def test_report_without_the_plot_library_lacks_only_the_replay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing() -> str:
        raise view.PageError("no chart.min.js")

    monkeypatch.setattr(view, "library", missing)
    summary, trace = made_up_run()
    run_report.write(tmp_path, summary, trace, COMMAND, draw("pair", trace))
    text = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert "No replay here: no chart.min.js." in text and "<h1>pair &amp; co</h1>" in text


def test_page_names_the_run_and_the_command_to_repeat_it(folder: Path) -> None:
    page = (folder / "report.html").read_text(encoding="utf-8")
    assert "<h1>pair &amp; co</h1>" in page
    assert "flotilla run pair --seed 7 --set &#x27;boat.1.eta=[0, 0, 0]&#x27;" in page
    assert "ab" * 32 in page


def test_page_shows_the_boat_that_never_settled_and_its_fault(folder: Path) -> None:
    first, second = re.findall(r"<tr style=.*</tr>", (folder / "report.html").read_text("utf-8"))
    assert "FAULT" not in first and "never" not in first
    assert "<td>never</td>" in second and "FORMATION 18.5 s, FAULT 1.5 s" in second


def test_live_run_of_a_single_boat_is_reported_without_digest_and_separation() -> None:
    summary, _ = made_up_run()
    pictures = {Path(name).stem: b"" for name in PICTURES}
    page = run_report.page({**summary, "digest": None, "min_separation_m": None}, pictures, COMMAND)
    assert "none: a live run" in page and "one boat" in page


def test_boats_that_did_not_move_or_err_can_be_reported(tmp_path: Path) -> None:
    summary, trace = made_up_run(ticks=2)
    still = {name: 0.0 * values for name, values in trace.items() if name != "t_s"}
    still["t_s"] = trace["t_s"]
    run_report.write(tmp_path, summary, still, COMMAND, draw("pair", still))
    assert (tmp_path / "report.html").exists()


def test_terminal_of_80_columns_shows_every_number_of_a_boat_in_one_line() -> None:
    console = Console(width=80, record=True, file=io.StringIO())
    console.print(run_report.table(made_up_run()[0]))
    lines = [line.split() for line in console.export_text().splitlines()]
    assert ["2", "1.0000", "1.0000", "never", "1.0000", "0.0000", "0.79"] in lines


@pytest.mark.parametrize(
    "lost", few([np.nan, np.inf, 1e200], [1e200]), ids=["nan", "infinite", "far away"]
)
def test_run_that_diverged_is_reported_up_to_where_it_did(tmp_path: Path, lost: float) -> None:
    summary, trace = made_up_run()
    trace["eta"][1200:, 2] = trace["error"][1200:, 1] = lost
    trace["thrust"][1200:, 1] = np.nan
    with np.errstate(all="ignore"):
        boats = metrics.boats(trace["t_s"], trace["error"], trace["thrust"], [{}, {}])
    lost_run: Summary = {**summary, "boats": boats, "min_separation_m": lost}
    one_run.save(tmp_path, lost_run, trace)
    run_report.write(tmp_path, lost_run, trace, COMMAND, draw("pair", trace))
    assert (tmp_path / "report.html").is_file()
    maps = plots.formation("pair", trace).axes
    assert maps[1].get_title(loc="left").startswith("up to 11.99 s")
    assert all(np.isfinite(axes.dataLim.get_points()).all() for axes in maps)
    told = json.loads((tmp_path / "summary.json").read_text(), parse_constant=pytest.fail)
    assert told["boats"][1]["rms_error_m"] is None


def test_map_names_the_plan_that_a_boat_leads_by() -> None:
    _, trace = made_up_run(ticks=200)
    for about, name in ({}, "virtual leader"), ({"boat": 1}, "plan of boat 1"):
        figure = plots.formation("pair", trace, Leader.model_validate(about).name)
        texts = [text.get_text() for text in figure.legends[0].get_texts()]
        assert texts == [name, "boat 1", "boat 2", "start"]


def test_errors_of_boats_that_start_in_their_slots_are_shown_from_a_millimetre() -> None:
    _, trace = made_up_run()
    trace["error"][..., 0] += 0.02
    trace["error"][0] = 0.0
    (axes,) = plots.errors("pair", trace).axes
    low, high = axes.get_ylim()
    assert low == pytest.approx(1e-3) and 2.0 < high < 10.0
    labels = {text.get_text(): text.get_position()[1] for text in axes.texts}
    assert 0.0 <= labels["boat 1"] < labels["boat 2"] < 1.0


def test_errors_far_under_a_millimetre_are_shown() -> None:
    _, trace = made_up_run()
    trace["error"] *= 1e-4
    (axes,) = plots.errors("pair", trace).axes
    assert axes.get_ylim()[0] == pytest.approx(1e-5)
