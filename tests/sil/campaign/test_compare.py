# SPDX-License-Identifier: MIT
"""Comparison of campaigns: real changes are reported, random ones are not."""

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from sil.campaign import campaign_figures, finished, pairs
from sil.cli.main import main
from tests.sil.campaign.made_up import Made

A = Made()
Compared = tuple[int, str]


@pytest.fixture
def compare(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> Callable[..., Compared]:
    """Compare two campaigns, written to folders a and b; exit status and output."""

    def run(a: Made, b: Made, *more: str) -> Compared:
        places = [str(made.write(tmp_path / name)) for name, made in (("a", a), ("b", b))]
        status = main(["compare", *places, *more])
        said = capsys.readouterr()
        return status, said.out + said.err

    return run


def test_campaign_is_the_same_as_itself(compare: Callable[..., Compared]) -> None:
    status, said = compare(A, A)
    assert status == 0 and "the same, bit for bit" in said
    assert "paired: 40 runs" in said


@pytest.mark.parametrize("gain", [1.1, 0.9])
def test_change_of_pairs_is_reported_and_only_a_worse_one_ends_with_status_1(
    gain: float, compare: Callable[..., Compared]
) -> None:
    status, said = compare(A, replace(A, gain=gain))
    assert status == (1 if gain > 1.0 else 0)
    verdict = "worse" if gain > 1.0 else "better"
    assert f"B is {verdict}: rms_error_m, rms_error_p95_m" in said


def test_change_within_the_margin_is_not_reported(compare: Callable[..., Compared]) -> None:
    status, said = compare(A, replace(A, gain=1.005))
    assert status == 0 and "no change that is certain" in said


def test_runs_with_another_seed_are_compared_without_pairs(
    compare: Callable[..., Compared],
) -> None:
    status, said = compare(A, replace(A, draw=2))
    assert status == 0 and "unpaired: other seeds" in said
    status, said = compare(A, replace(A, draw=2, gain=1.5))
    assert status == 1 and "rms_error_m" in said


def test_runs_that_draw_something_else_from_the_same_seed_are_no_pairs(
    compare: Callable[..., Compared], tmp_path: Path
) -> None:
    compare(A, A)
    Made(draw=2).write(tmp_path / "other")
    (tmp_path / "other" / "draws.parquet").replace(tmp_path / "b" / "draws.parquet")
    pairing = pairs.pair(finished.read(tmp_path / "a"), finished.read(tmp_path / "b"))
    assert not pairing.paired and "what it draws differs" in pairing.about


def test_only_runs_that_both_have_are_pairs(compare: Callable[..., Compared]) -> None:
    status, said = compare(A, Made(runs=25, gain=1.2, failed=(3,)))
    assert status == 1 and "paired: 25 runs" in said
    assert "thrust" not in said.partition("B is worse")[2]


@pytest.mark.nightly
def test_same_code_with_another_seed_raises_at_most_one_alarm_in_fifty(tmp_path: Path) -> None:
    alarms = []
    for repetition in range(50):
        places = [tmp_path / f"{repetition}-{name}" for name in "ab"]
        for number, place in enumerate(places):
            Made(runs=24, draw=100 + 2 * repetition + number).write(place, over_time=False)
        a, b = map(finished.read, places)
        found = campaign_figures.compare(a, b, paired=False)
        alarms += [(repetition, key) for key, one in found.items() if one.verdict != "same"]
    assert len(alarms) <= 1, alarms


def test_diverged_runs_count_as_infinite_and_enough_of_them_are_worse(
    compare: Callable[..., Compared], tmp_path: Path
) -> None:
    file = tmp_path / "told.json"
    status, said = compare(A, replace(A, diverged=tuple(range(14))), "--json", str(file))
    told = {one["figure"]: one for one in json.loads(file.read_text())["figures"]}
    assert status == 1 and "∞" in said
    assert told["lost"]["b"] == pytest.approx(14 / 40) and told["lost"]["verdict"] == "worse"
    assert told["rms_error_p95_m"]["b"] is None and told["rms_error_p95_m"]["verdict"] == "worse"
    # of the 26 that did not, nothing changed
    assert told["thrust_rms_N"]["ratio"] == 1.0


def test_json_has_the_verdict_and_figures_of_the_table(
    compare: Callable[..., Compared], tmp_path: Path
) -> None:
    file = tmp_path / "told.json"
    compare(A, replace(A, gain=1.2), "--json", str(file))
    told = json.loads(file.read_text())
    assert told["worse"] == ["rms_error_m", "rms_error_p95_m"] and told["better"] == []
    assert told["paired"] and told["runs"] == [40, 40]
    first = told["figures"][0]
    assert first["ratio"] == pytest.approx(1.2) and first["low"] <= 1.2 <= first["high"]


def test_a_single_boat_has_no_separation(compare: Callable[..., Compared]) -> None:
    status, said = compare(Made(boats=1), Made(boats=1, gain=1.1))
    assert status == 1 and "closest two boats" not in said


def test_differences_in_sailing_are_reported(
    compare: Callable[..., Compared], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    compare(A, A)
    path = tmp_path / "b" / "campaign.json"
    header = json.loads(path.read_text())
    header["parameters"] = {"LAW_KX": 0.24}
    header["document"]["boat"][1]["offset_m"] = [1.0, 0.0]
    path.write_text(json.dumps(header))
    assert main(["compare", str(tmp_path / "a"), str(tmp_path / "b")]) == 0
    said = capsys.readouterr().out
    assert "parameters.LAW_KX: not given, in B 0.24" in said
    assert "boat.2.offset_m: [0.0, 0.0], in B [1.0, 0.0]" in said


@pytest.mark.parametrize(
    ("key", "value", "said"),
    [
        ("duration_s", 20, "not one duration_s: 120, in B 20"),
        ("rate_hz", 50, "not one rate_hz: not given, in B 50"),
        ("boat", [{"follows": 0}] * 4, "not one follows: [0, 1, 2, 3], in B [0, 0, 0, 0]"),
    ],
)
def test_runs_of_another_shape_are_not_compared(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], key: str, value: object, said: str
) -> None:
    places = [str(A.write(tmp_path / name)) for name in "ab"]
    path = tmp_path / "b" / "campaign.json"
    header = json.loads(path.read_text())
    header["document"][key] = value
    path.write_text(json.dumps(header))
    assert main(["compare", *places]) == 2
    assert capsys.readouterr().err == f"error: {said}\n"


@pytest.mark.parametrize(
    ("b", "what"),
    [
        (Made(scenario="other"), "not one scenario"),
        (Made(boats=3), "not one scenario"),
        (Made(runs=5), "at least 20 are needed"),
    ],
)
def test_incomparable_campaigns_are_reported_in_one_line(
    b: Made, what: str, compare: Callable[..., Compared]
) -> None:
    status, said = compare(A, b)
    assert status == 2 and said.startswith("error: ") and said.count("\n") == 1
    assert what in said


def test_folder_without_a_campaign_is_reported_with_the_command_to_make_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["compare", str(tmp_path / "none"), str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1 and "flotilla campaign SCENARIO" in error


@pytest.mark.parametrize("name", ["campaign.json", "table.parquet", "draws.parquet"])
def test_damaged_or_missing_file_is_reported_by_its_name(
    name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    places = [A.write(tmp_path / letter) for letter in "ab"]
    for spoil in (lambda path: path.write_bytes(b"no"), lambda path: path.unlink()):
        spoil(places[1] / name)
        assert main(["compare", *map(str, places)]) == 2
        error = capsys.readouterr().err
        assert error.count("\n") == 1 and f"b/{name}" in error.replace("b: no ", "b/")
