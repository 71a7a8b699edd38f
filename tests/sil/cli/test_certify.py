# SPDX-License-Identifier: MIT
"""tools/certify: exit status, files and error messages."""

import json
import re
from pathlib import Path
from typing import Any

import pytest

from sil.certificate import certificate, chain, margins, search
from sil.cli.main import main
from tests.sil.certificate.made_up import SINE
from tests.sil.mistakes import assert_told_in_one_line

QUICK = 200


@pytest.fixture(autouse=True)
def quick_search(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(search, "SEARCH_CYCLES", QUICK)
    monkeypatch.setattr(margins, "STEPS", 0)
    monkeypatch.setattr(chain, "MOST_DEPTH", 0)


@pytest.fixture
def no_chain(monkeypatch: pytest.MonkeyPatch) -> None:
    """Skips the analysis of chains, where a test does not need it."""
    monkeypatch.setattr(certificate, "_chain", lambda *_: (None, None))


def certified(out: Path, *arguments: str) -> tuple[int, dict[str, Any]]:
    status = main(["certify", *arguments, "--out", str(out)])
    document: dict[str, Any] = json.loads((out / "certificate.json").read_text(encoding="utf-8"))
    assert document["certified"] is (status == 0)
    return status, document


def test_papers_diamond_is_certified_but_not_by_the_small_gain_test(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    also = tmp_path / "also.json"
    arguments = ("diamond", "--law", "paper", "--json", str(also))
    status, document = certified(tmp_path / "out", *arguments)
    assert status == 0
    (leg,) = document["legs"]
    (case,) = leg["cases"]
    assert (leg["T_s"], leg["mu"]) == pytest.approx((20.944, 1.294), abs=5e-4)
    assert case["boats"] == [1, 2, 3, 4]
    assert 1.6 < case["small_gain"]["product"] < 1.9
    assert case["floquet"]["multipliers"][0] == pytest.approx([0.157, 0.0], abs=1e-3)
    assert case["sampled"]["decay"] == pytest.approx(0.088, abs=1e-3)
    assert case["thrust"]["margin"] == pytest.approx(0.968, abs=1e-3)
    assert also.read_bytes() == (tmp_path / "out" / "certificate.json").read_bytes()
    assert (tmp_path / "out" / "decay.png").read_bytes().startswith(b"\x89PNG")
    said = capsys.readouterr().out
    assert "sufficient only" in said and "certified about the formation" in said


@pytest.mark.usefixtures("no_chain")
def test_wild_yaw_gain_is_not_certified(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "[a]"
    at_50_hz = ("--set", "rate_hz=50", "--set", "navigation.rate_hz=50")
    wild = ("diamond", "--law", "paper", *at_50_hz, "--param", "LAW_KDR=500")
    status, document = certified(out, *wild)
    assert status == 1
    assert "grow" in document["verdict"]
    assert f"results: {out}/certificate.html" in capsys.readouterr().out


def test_ten_boats_that_follow_each_other_are_not_certified(tmp_path: Path) -> None:
    late = ("line10", "--set", "link.delay_s=0.1")
    status, document = certified(tmp_path / "before", *late, "--param", "LAW_REF=0")
    assert status == 1
    (leg,) = document["legs"]
    found = leg["chain"]
    depth = found["certified"]
    assert 4 <= depth <= 6
    assert (
        f"certified to depth {depth}: from boat {depth + 1} on it cannot hold"
        in (document["verdict"])
    )
    assert max(found["yaw"]["hop"]) == pytest.approx(2.1, abs=0.1)
    assert (tmp_path / "before" / "chain.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("boats", [3, pytest.param(10, marks=pytest.mark.nightly)])
def test_boats_that_hear_the_reference_are_certified(tmp_path: Path, boats: int) -> None:
    line = ", ".join(
        f"{{follows={i}, offset_m=[{-3.0 if i else 0.0}, 0.0], eta=[{-3.3 * i}, 0.7, 0.2]}}"
        for i in range(boats)
    )
    fewer = ("--set", f"boat=[{line}]") if boats < 10 else ()
    status, document = certified(tmp_path, "line10", "--set", "link.delay_s=0.1", *fewer)
    assert status == 0
    (leg,) = document["legs"]
    assert leg["chain"]["certified"] == boats
    assert max(leg["chain"]["yaw"]["hop"]) < 0.3


@pytest.mark.nightly  # each push: the next one
@pytest.mark.usefixtures("no_chain")
def test_weak_propellers_are_not_certified(tmp_path: Path) -> None:
    weak = ("--set", "propellers.forward_max_N=1.2", "--param", "THR_FWD_MAX=1.2")
    status, document = certified(tmp_path, "diamond", "--law", "paper", *weak)
    assert status == 1
    assert "needs 33 % more forward thrust than the" in document["verdict"]


@pytest.mark.usefixtures("no_chain")
def test_propellers_without_reverse_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ahead = ("--set", "propellers.reverse_max_N=0", "--set", "leader.input.1.yaw_sine_Nm=1.5")
    status, document = certified(tmp_path, "diamond", "--law", "paper", *ahead)
    told = capsys.readouterr().out
    assert status == 1 and not re.search(r"\binf\b", told)
    assert "the slot needs reverse thrust, but the" in document["verdict"]


@pytest.mark.usefixtures("no_chain")
def test_straight_leg_is_not_certified_with_the_papers_law(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, document = certified(tmp_path / "paper", "diamond", "--law", "paper", "--set", SINE)
    assert status == 1
    assert "the leader does not turn" in document["verdict"]
    assert document["legs"][0]["persistently_exciting"] is False
    assert document["legs"][0]["cases"][0]["small_gain"]["product"] is None
    assert "no persistent excitation" in " ".join(capsys.readouterr().out.split())


@pytest.mark.usefixtures("no_chain")
def test_straight_leg_is_certified_with_the_products_law_each_time_with_the_same_words(
    tmp_path: Path,
) -> None:
    certify_twice(tmp_path)


@pytest.mark.nightly
def test_chains_are_certified_each_time_with_the_same_words_too(tmp_path: Path) -> None:
    certify_twice(tmp_path)


def certify_twice(tmp_path: Path) -> None:
    for name in ("one", "two"):
        leg = ("diamond", "--law", "product", "--set", SINE)
        assert certified(tmp_path / name, *leg)[0] == 0
    one, two = ((tmp_path / name / "certificate.json").read_bytes() for name in ("one", "two"))
    assert one == two


@pytest.mark.usefixtures("no_chain")
def test_leader_that_stops_and_goes_is_examined_moving_and_at_rest(tmp_path: Path) -> None:
    inputs = "[{surge_N = 2.0}, {from_s = 60.0}, {from_s = 90.0, surge_N = 2.0}]"
    arguments = ("diamond", "--law", "product", "--set", f"leader.input={inputs}")
    status, document = certified(tmp_path, *arguments)
    moving, still = document["legs"]
    assert status == 0
    assert (moving["kind"], moving["from_s"]) == ("straight", [0.0, 90.0])
    assert (still["kind"], still["from_s"]) == ("rest", [60.0])
    assert still["cases"][0]["sampled"]["neutral"] == 1
    assert "errors abeam stay as they are up to 1.5 m" in document["verdict"]


def test_leader_that_never_moves_is_no_reason_to_fail(tmp_path: Path) -> None:
    status, document = certified(tmp_path, "diamond", "--set", "leader.input=[]")
    assert status == 0
    assert document["search"] is None


@pytest.mark.usefixtures("no_chain")
def test_constant_turn_has_no_period_and_the_reason_is_given(tmp_path: Path) -> None:
    turn = ("--set", SINE, "--set", "leader.input.1.yaw_Nm=0.15", "--param", "THR_SLEW=5")
    document = certified(tmp_path, "diamond", *turn)[1]
    (leg,) = document["legs"]
    assert leg["T_s"] is None and leg["mu"] is None and "any" in leg["T"]
    assert leg["mu_per_T_radps2"] == pytest.approx(leg["omega_max_radps"] ** 2)
    assert leg["persistently_exciting"] is True
    assert any("THR_SLEW = 5" in note for note in document["notes"])


def test_unwritable_path_is_reported_before_anything_is_computed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sil.certificate.certificate.certify", lambda *_: pytest.fail("computed"))
    (tmp_path / "file").touch()
    wrong = str(tmp_path / "file" / "x.json")
    assert main(["certify", "diamond", "--out", str(tmp_path / "out"), "--json", wrong]) == 2
    assert capsys.readouterr().err == f"error: {wrong}: Not a directory\n"
    assert not (tmp_path / "out").exists()


def test_interrupted_run_ends_with_status_130_and_leaves_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("sil.certificate.certificate.certify", interrupt)
    assert main(["certify", "diamond", "--out", str(tmp_path / "out")]) == 130
    assert capsys.readouterr().err == "interrupted\n"
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["dimond"], 'unknown scenario "dimond"'),
        (["diamond", "--param", "LAW_KX=9"], "LAW_KX = 9.0 is out of range"),
        (["diamond", "--param", "LAW_KX"], "must be NAME=VALUE"),
        (["diamond", "--set", "duration_s=-1"], "greater than 0"),
        (["diamond", "--seed", "-1"], "greater than or equal to 0"),
    ],
)
def test_a_mistake_is_reported_in_one_line(
    arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    assert main(["certify", *arguments, "--out", str(out)]) == 2
    assert_told_in_one_line(said, capsys)
    assert not out.exists()
