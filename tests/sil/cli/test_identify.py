# SPDX-License-Identifier: MIT
"""The command from a log to files that others load."""

from pathlib import Path

import numpy as np
import pytest
from pymavlink import mavparm

from sil.cli.main import main
from sil.identify.voyage_log import SAMPLE_S
from sil.logs.own_motion import COLUMNS
from sil.scenario import scenario
from tests.sil.identify.sailed import HULL, levels, sail
from tests.sil.mistakes import assert_told_in_one_line

SIZES = ("--mass", "17.14", "--length", "1.2", "--arm", "0.28")


def written(folder: Path, *, swapped: bool) -> Path:
    rng = np.random.default_rng(3)
    log = sail(levels(rng, 130.0), rng)
    commands = log.commands[:, ::-1] if swapped else log.commands
    t = np.arange(len(log.motion)) * SAMPLE_S
    path = folder / "log.csv"
    rows = np.column_stack([t, log.motion, commands])
    np.savetxt(path, rows, "%.9g", ",", header=COLUMNS, comments="")
    return path


def test_a_log_becomes_a_page_parameters_and_a_hull_for_scenarios(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "[out]"
    log = written(tmp_path, swapped=False)
    assert main(["identify", str(log), *SIZES, "--out", str(out)]) == 0
    assert f"results: {out}/identify.html" in capsys.readouterr().out
    loaded = mavparm.MAVParmDict()
    assert loaded.load(str(out / "hull.param"))
    assert loaded["VES_M11"] == pytest.approx(HULL.m11, rel=1e-3)
    fleet = scenario.load("diamond", [f"hull={out / 'hull.toml'}"], "product")
    assert fleet.vessel.hull.m33 == pytest.approx(HULL.m33, rel=0.1)
    page = (out / "identify.html").read_text(encoding="utf-8")
    assert "Good: predictions over 10 s of logs" in page and "data:image/png" in page


@pytest.mark.parametrize(
    ("sizes", "said"),
    [
        (("--mass", "1e300"), "--mass 1e+300: VES_M11 is from 0.01 to 100000 kg"),
        (("--length", "150"), "--length 150: BOAT_LEN is from 0.1 to 50 m; is the value in m?"),
        (("--arm", "28"), "--arm 28: THR_ARM is from 0.01 to 20 m"),
        (("--arm", "0.001"), "--arm 0.001: THR_ARM is from 0.01 to 20 m"),
        (("--mass", "17140"), "--mass 17140 is too heavy for --length 1.2: the mass is in kg, the"),
        (("--length", "12"), "--mass 17.14 is too light for --length 12: the mass is in kg, the"),
        (("--arm", "2.8"), "--arm 2.8 is more than --length 1.2: both are in metres"),
    ],
)
def test_impossible_sizes_are_refused_before_the_search(
    sizes: tuple[str, str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, out = tmp_path / "log.csv", tmp_path / "out"
    log.write_text("")
    assert main(["identify", str(log), *SIZES, *sizes, "--out", str(out)]) == 2
    assert_told_in_one_line(said, capsys)
    assert not out.exists()


@pytest.mark.nightly  # each push: tests/sil/identify/test_propeller_signs.py
def test_swapped_propellers_get_no_parameters(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    log = written(tmp_path, swapped=True)
    assert main(["identify", str(log), *SIZES, "--out", str(out)]) == 1
    assert capsys.readouterr().out.lstrip().startswith("Not usable as it is: port and")
    assert {path.name for path in out.iterdir()} == {
        "identify.html",
        "identify.json",
        "predictions.png",
    }


def test_an_unwritable_folder_is_reported_before_any_log_is_read(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sil.identify.log_files.read", lambda _: pytest.fail("read"))
    (tmp_path / "file").touch()
    out = str(tmp_path / "file" / "out")
    assert main(["identify", "voyage.csv", *SIZES, "--out", out]) == 2
    assert capsys.readouterr().err == f"error: {out}: Not a directory\n"


def test_a_log_that_is_not_there_is_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = tmp_path / "none.csv"
    assert main(["identify", str(missing), *SIZES, "--out", str(tmp_path / "out")]) == 2
    assert str(missing) in capsys.readouterr().err
