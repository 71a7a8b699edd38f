# SPDX-License-Identifier: MIT
"""The matrix of faults judges a boat's response by the row's limits alone."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from sil.cli.main import main
from sil.faults import fault_report, matrix, rows
from sil.faults.fault_outcome import Outcome
from sil.faults.rows import Row
from sil.faults.watch import STATES
from sil.lockstep.world import Run, sail
from tests.sil.mistakes import assert_told_in_one_line

FAULT = {"kind": "own_silent", "agent": 1, "at_s": 1.0, "for_s": 2.0}
TICKS = 100


def judged(*spells: tuple[str, int, float], **keys: Any) -> Outcome:
    """The outcome of a boat with these spells: state, ticks of 0.1 s, commanded thrust (N)."""
    row = Row.model_validate({"name": "it", "fault": [FAULT], "states": ["HOLD"], **keys})
    states = np.concatenate([np.full(n, STATES[name], np.uint8) for name, n, _ in spells])
    thrust_N = np.concatenate([np.full((n, 2), level) for _, n, level in spells])
    return matrix._Seen(row, 0.1, states, thrust_N, np.full(len(states), 0.1)).judge(row.begins_s)


GOOD = (("FORMATION", 13, 5.0), ("HOLD", 30, 0.0), ("FORMATION", 20, 5.0))
WELL = {"detected_s": 0.5, "recovery": "operator", "recovered_s": 1.5}


def test_a_boat_that_keeps_the_limits_passes() -> None:
    assert judged(*GOOD, **WELL) == Outcome("it", 0.3, "HOLD", 0.0, 1.3, True, "")


@pytest.mark.parametrize(
    ("spells", "keys", "why"),
    [
        (GOOD, {"detected_s": 0.2}, "detected after 0.30 s, not 0.2 s"),
        (GOOD, {"recovered_s": 1.2}, "back after 1.30 s, not 1.2 s"),
        (GOOD, {"states": ["COAST"]}, "HOLD, not COAST"),
        (GOOD, {"then": "FAULT", "then_s": 9.0}, "HOLD for 3.00 s, then FORMATION"),
        ((("FORMATION", 60, 5.0),), {}, "not detected; expected HOLD"),
        ((*GOOD[:1], ("HOLD", 30, 0.0)), {}, "not back in FORMATION"),
        ((*GOOD[:1], ("HOLD", 30, 0.5), GOOD[2]), {}, "0.50 N commanded where none is allowed"),
        ((*GOOD[:1], ("HOLD", 5, 0.0), GOOD[2]), {}, "before the operator's command"),
        ((("HOLD", 5, 0.0), *GOOD), {}, "left FORMATION before anything went wrong"),
        (
            (GOOD[0], ("COAST", 5, 4.0), ("COAST", 5, 4.5), GOOD[2]),
            {"states": ["COAST"], "recovery": "automatic"},
            "thrust rose by 0.50 N in COAST",
        ),
        (
            (GOOD[0], ("COAST", 5, 5.5), GOOD[2]),
            {"states": ["COAST"], "recovery": "automatic"},
            "thrust rose by 0.50 N in COAST",
        ),
        (GOOD, {"error_m": 0.05}, "0.10 m from its slot, not 0.05 m"),
        (GOOD, {"lasts_s": 3.1}, "HOLD for 3.00 s only"),
    ],
)
def test_a_boat_that_breaks_a_limit_fails_with_the_reason(
    spells: tuple[Any, ...], keys: dict[str, Any], why: str
) -> None:
    outcome = judged(*spells, **{**WELL, **keys})
    assert not outcome.passed
    assert why in outcome.why


HOME = (("FORMATION", 13, 5.0), ("HOLD", 17, 0.0), ("MANUAL", 20, 0.0), ("MANUAL", 20, 5.0))


@pytest.mark.parametrize(
    ("spells", "why"),
    [
        (HOME, ""),
        (HOME[:3], "not driven home: MANUAL in the end"),
        ((*HOME, ("HOLD", 5, 0.0)), "not driven home: HOLD in the end"),
        ((*HOME[:2], ("MANUAL", 40, 5.0)), "before the sticks were at neutral"),
        ((HOME[0], ("HOLD", 45, 0.0), HOME[3]), "began too late"),
    ],
)
def test_a_boat_is_driven_home_by_sticks_that_were_at_neutral(
    spells: tuple[Any, ...], why: str
) -> None:
    outcome = judged(*spells, home_s=2.0)
    assert outcome.passed == (not why)
    assert why in outcome.why


def test_a_boat_that_does_not_report_the_rows_words_fails() -> None:
    row = Row.model_validate({"name": "it", "fault": [FAULT], "states": ["HOLD"], "told": "fix"})
    well = judged(*GOOD, **WELL)
    assert matrix._heard(row, ["HOLD", "poor navigation: fix"], well) == well
    silent = matrix._heard(row, ["HOLD"], well)
    assert not silent.passed and silent.why == "\"fix\" was not told, but ['HOLD']"


def test_a_boat_keeps_its_distance_from_the_place_ahead_of_it() -> None:
    row = Row.model_validate(
        {"name": "it", "fault": [FAULT], "states": ["HOLD"], "keeps_m": [3.0, 1.0]}
    )
    well, t = judged(*GOOD, **WELL), np.arange(TICKS)
    # It sails east at 1 m/s, and is at 1 m when the fault begins: the place is at 4 m.
    eta = np.column_stack((0.0 * t, 0.1 * t, 0.0 * t + np.pi / 2))
    assert matrix._kept(row, eta[:30], 0.1, well) == well
    near = matrix._kept(row, eta[:32], 0.1, well)
    assert not near.passed and near.why == "0.90 m from the other vessel, not 1 m"


def test_an_operator_who_insists_asks_from_the_beginning_on() -> None:
    keys = {"name": "it", "fault": [FAULT], "states": ["HOLD"]}
    assert Row.model_validate(keys).asks_s == 3.0
    assert Row.model_validate({**keys, "insists": True}).asks_s == 1.0


def test_thrust_may_last_as_long_as_the_row_says() -> None:
    spells = (GOOD[0], ("HOLD", 3, 5.0), ("HOLD", 27, 0.0), GOOD[2])
    assert judged(*spells, **WELL, off_s=0.3).passed
    assert not judged(*spells, **WELL, off_s=0.2).passed


def test_a_boat_may_stay_in_formation_where_the_row_allows_it() -> None:
    assert judged(("FORMATION", 60, 5.0), states=["FORMATION"], error_m=0.1).passed


def test_rows_have_names_of_their_own_and_can_be_sailed() -> None:
    every = rows.read()
    assert len({row.name for row in every}) == len(every) >= 40
    for row in every:
        assert row.scenario().duration_s > row.ends_s + (row.recovered_s or 0.0)


NAMES = [row.name for row in rows.read()]


@pytest.fixture(scope="module")
def outcomes() -> dict[str, Outcome]:
    """The outcomes of all rows, sailed together."""
    return {one.fault: one for one in matrix.sail_all(rows.read())}


@pytest.mark.parametrize("name", NAMES)
def test_every_fault_of_the_matrix_stays_within_its_limits(
    outcomes: dict[str, Outcome], name: str
) -> None:
    assert outcomes[name].passed, outcomes[name]


def test_a_fault_that_formation_survives_still_changes_the_bytes() -> None:
    """Such a row would pass without its fault too, so compare the wires with an undisturbed run."""
    may_go_on = [row for row in rows.read() if "FORMATION" in row.states]
    assert len(may_go_on) >= 10
    ill = [row.scenario() for row in may_go_on]
    well = [one.model_copy(update={"fault": ()}) for one in ill]
    digests = [run.digest for run in sail([*ill, *well], {}, digest=True) if isinstance(run, Run)]
    assert len(digests) == 2 * len(may_go_on)
    without = digests[len(may_go_on) :]
    pairs = zip(may_go_on, digests, without, strict=False)
    assert not [row.name for row, one, other in pairs if one == other]


def test_the_command_writes_its_results_to_files(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["faults", "--only", "esc_both_silent", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "1 passed, 0 failed"
    assert "esc_both_silent" in (tmp_path / "faults.json").read_text()
    assert (tmp_path / "faults.md").read_text().endswith("1 passed, 0 failed\n")


def test_the_command_fails_if_a_row_fails(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (row,) = (row for row in rows.read() if row.name == "own_silent")
    monkeypatch.setattr(rows, "read", lambda: (row.model_copy(update={"detected_s": 0.1}),))
    assert main(["faults", "--out", str(tmp_path)]) == 1
    assert capsys.readouterr().out.splitlines()[-1] == "0 passed, 1 failed"
    assert "detected after 0.45 s" in (tmp_path / "faults.md").read_text()


def test_a_matrix_that_is_interrupted_has_not_passed(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(matrix, "sail_all", interrupt)
    assert main(["faults", "--out", str(tmp_path)]) == 130
    assert capsys.readouterr().err == "interrupted\n"
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--only", "kraken"], "--only kraken: no fault's name contains that"),
        (["--soak", "0"], "must be positive"),
        (["--seed", "3"], "--seed needs --soak"),
        (["--soak", "1", "--only", "leader"], "leave out --only and --live"),
        (["--soak", "1", "--live"], "leave out --only and --live"),
    ],
)
def test_mistakes_are_reported_in_one_line(
    arguments: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["faults", *arguments, "--out", str(tmp_path)]) == 2
    assert_told_in_one_line(said, capsys)


def test_the_last_line_counts_passed_and_failed_rows() -> None:
    well, ill = judged(*GOOD, **WELL), judged(*GOOD, **{**WELL, "detected_s": 0.0})
    assert fault_report.summary([well, ill, well]) == "2 passed, 1 failed"
