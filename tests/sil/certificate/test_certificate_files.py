# SPDX-License-Identifier: MIT
"""certificate.json and decay.png of a scenario with two kinds of boats and two legs."""

import html
import io
import json
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from rich.console import Console

from sil.certificate import certificate_files, certificate_report
from sil.certificate.certificate import Certificate
from tests.sil.certificate.made_up import quick_certificate
from tests.turns import some

INPUTS = "leader.input=[{surge_N = 2.0}, {from_s = 100.0}]"


@pytest.fixture(scope="module")
def two_legs() -> Certificate:
    overrides = [INPUTS, "boat.3.parameters={LAW_KX = 0.4}"]
    return quick_certificate("diamond", overrides, "product")


@pytest.fixture(scope="module")
def written(two_legs: Certificate, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("certificate")
    certificate_files.write(two_legs, folder, None)
    return folder


def test_nothing_is_left_half_written(written: Path) -> None:
    assert {file.name for file in written.iterdir()} == {
        "certificate.html",
        "certificate.json",
        "certificate.param",
        "certificate.params",
        "decay.png",
        "chain.png",
    }
    assert (written / "decay.png").read_bytes().startswith(b"\x89PNG")


def test_certified_depth_is_written_as_a_parameter_and_none_where_no_depth_is_certified(
    two_legs: Certificate, written: Path
) -> None:
    depth = json.loads((written / "certificate.json").read_text(encoding="utf-8"))["depth"]
    assert depth == two_legs.depth and depth >= 1
    lines = (written / "certificate.param").read_text(encoding="utf-8").splitlines()
    assert lines[1:] == [f"FORM_DEPTH,{depth}"]
    none = [replace(leg, chain="boat 2 leaves FORMATION") for leg in two_legs.legs]
    refused = replace(two_legs, legs=none)
    assert refused.depth == 0
    assert set(certificate_files.parameter_files(refused).values()) == {""}


def test_page_begins_with_the_verdict_and_names_no_label_of_the_papers_source(
    written: Path,
) -> None:
    page = (written / "certificate.html").read_text(encoding="utf-8")
    said = json.loads((written / "certificate.json").read_text(encoding="utf-8"))["verdict"]
    assert page.index(html.escape(said)) < page.index("small gain, position") < page.index("<img ")
    assert "eq:" not in page


def test_impossible_folder_is_reported_by_its_name_and_nothing_is_left(
    tmp_path: Path,
) -> None:
    (tmp_path / "file").touch()
    for folder, also in (("file/out", None), ("out", "file/also.json"), ("out", ".")):
        other = None if also is None else tmp_path / also
        with pytest.raises(OSError, match=re.escape(str(other or tmp_path / folder))):
            certificate_files.check(tmp_path / folder, other)
    certificate_files.check(tmp_path / "new" / "out", tmp_path / "new" / "also.json")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_file_that_cannot_be_replaced_leaves_no_part(two_legs: Certificate, tmp_path: Path) -> None:
    (tmp_path / "decay.png").mkdir()
    with pytest.raises(OSError, match=re.escape(str(tmp_path))):
        certificate_files.write(two_legs, tmp_path, None)
    assert [path.name for path in tmp_path.iterdir()] == ["decay.png"]


def test_symbolic_link_is_followed_and_kept(two_legs: Certificate, tmp_path: Path) -> None:
    file, link = tmp_path / "target.json", tmp_path / "link.json"
    file.touch()
    link.symlink_to(file)
    certificate_files.write(two_legs, tmp_path, link)
    assert link.is_symlink() and json.loads(file.read_text("utf-8"))["scenario"] == "diamond"


def test_document_has_every_leg_and_every_kind_of_boat(written: Path) -> None:
    document: dict[str, Any] = json.loads((written / "certificate.json").read_text("utf-8"))
    legs = document["legs"]
    assert [leg["kind"] for leg in legs] == ["straight", "rest"]
    for leg in legs:
        assert [case["boats"] for case in leg["cases"]] == [[1, 2, 4], [3]]
    moving, still = (leg["cases"][1] for leg in legs)
    assert moving["parameters"]["LAW_KX"] == pytest.approx(0.4)
    curve = moving["decay_against_k_x"]
    assert len(curve["k_x"]) == len(curve["floquet"]) == len(curve["sampled"]) > 20
    assert still["decay_against_k_x"]["sampled"] == []


def test_infinity_is_written_as_null(written: Path) -> None:
    document = json.loads((written / "certificate.json").read_text("utf-8"))
    still = document["legs"][1]["cases"][0]["small_gain"]
    assert still["product"] is None and still["gamma1"] is None and still["bound"] == 0.0


def test_terminal_of_80_columns_shows_every_number_whole(two_legs: Certificate) -> None:
    console = Console(width=80, record=True, file=io.StringIO())
    certificate_report.tell(two_legs, console)
    text = console.export_text()
    assert "…" not in text.replace(" … ", "") and "boats 1, 2, 4" in text
    for case in some(two_legs.legs[0].cases):
        assert f"{case.sampled.decay:.4f}" in text
