# SPDX-License-Identifier: MIT
"""The stages of tools/test: what makes a run fail, and its final report."""

import threading
from pathlib import Path

import pytest

from tests import stages
from tests.stages import Result, Stage

PASSING = Stage("passing", ("echo '[doctest] test cases:  2 |  2 passed | 0 failed'",), tests=True)
CASE = '<testcase classname="boat" name="sails" time="1"><skipped message="{}"/></testcase>'


@pytest.fixture(autouse=True)
def _own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stages, "OUT", tmp_path)
    monkeypatch.setattr(stages, "ROOT", tmp_path)


def ended(todo: list[Stage], *, no_skip: bool = False) -> int:
    return stages.verdict(stages.run_all(todo, stages.tell), no_skip=no_skip)


def reporting(tmp_path: Path, message: str) -> Stage:
    """A stage whose report contains a passed and a skipped test."""
    sailed = '<testcase classname="boat" name="floats" time="1"/>'
    report = f"<testsuite>{sailed}{CASE.format(message)}</testsuite>"
    return Stage("boats", (f"echo '{report}' > {tmp_path}/boats.xml",), tests=True)


def test_a_run_that_passes_ends_with_the_sum_of_its_tests(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert ended([PASSING, Stage("lint", ("true",))]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "tests: 2 passed, 0 failed, 0 skipped"


def test_a_stage_that_fails_fails_the_run_and_those_that_need_it_do_not_begin(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    broken = Stage("build", ("echo no compiler; exit 3", "touch later"))
    needy = Stage("boats", ("touch begun",), ("build",), tests=True)
    assert ended([broken, needy, PASSING]) == 1
    out = capsys.readouterr().out
    assert "no compiler" in out and "ended with status 3" in out and "needs build" in out
    assert not (tmp_path / "later").exists() and not (tmp_path / "begun").exists()


def test_a_stage_that_runs_no_test_fails(capsys: pytest.CaptureFixture[str]) -> None:
    assert ended([Stage("boats", ("true",), tests=True)]) == 1
    assert "no test was run" in capsys.readouterr().out


@pytest.mark.parametrize("no_skip", [False, True])
def test_a_missing_vcan_is_reported_and_fails_a_run_that_may_not_skip(
    capsys: pytest.CaptureFixture[str], *, no_skip: bool
) -> None:
    vcan = Stage("vcan", ("echo no vcan here; exit 77",), tests=True)
    assert ended([vcan, PASSING], no_skip=no_skip) == no_skip
    told = capsys.readouterr().out.splitlines()[-2]
    begin = "FAILED, SKIPPED" if no_skip else "NOT TESTED"
    assert told == f"{begin}: tests on the kernel's CAN: no vcan here"


@pytest.mark.parametrize("no_skip", [False, True])
def test_a_skipped_test_is_reported_with_its_reason(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, *, no_skip: bool
) -> None:
    assert ended([reporting(tmp_path, "no browser")], no_skip=no_skip) == no_skip
    *_, told, sums = capsys.readouterr().out.splitlines()
    assert told.endswith(": boat::sails: no browser")
    assert sums == f"tests: 1 passed, {int(no_skip)} failed, {int(not no_skip)} skipped"


def test_a_run_that_was_too_slow_to_be_judged_neither_passes_nor_fails(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert ended([reporting(tmp_path, "not judged: boat2 late in 9%")], no_skip=True) == 0
    *_, told, sums = capsys.readouterr().out.splitlines()
    assert told == "NOT JUDGED: boat::sails: boat2 late in 9%"
    assert sums == "tests: 1 passed, 0 failed, 1 skipped"


@pytest.mark.parametrize("again", ["true", "false", ""])
def test_a_live_test_that_fails_is_judged_only_if_it_fails_again(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, again: str
) -> None:
    late = '<testcase classname="boat" name="sails"><failure message="late by 1 s"/></testcase>'
    report = f'<testsuite><testcase classname="boat" name="floats"/>{late}</testsuite>'
    write = f"echo '{report}' > {tmp_path}/live.xml; exit 1"
    passed = again == "true"
    live = Stage("live", ("true", write), tests=True, again=again)
    assert ended([live], no_skip=True) == (not passed)
    out = capsys.readouterr().out
    told = "NOT JUDGED: boat::sails: passed when repeated; failed with: late by 1 s"
    assert (told in out) == passed


def test_of_two_live_stages_the_second_waits_and_others_run_beside_the_first(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    beside, ended = threading.Barrier(2, timeout=30), []

    def run(stage: Stage) -> Result:
        if stage.name in {"vcan", "fuzz"}:
            beside.wait()
        if stage.name == "live":
            assert "vcan" in ended
        ended.append(stage.name)
        return Result(stage)

    monkeypatch.setattr(stages, "run", run)
    todo = [Stage("vcan", (), kind="live"), Stage("live", (), kind="live"), Stage("fuzz", ())]
    assert len(stages.run_all(todo, lambda _: None)) == len(ended) == 3


def test_every_live_test_is_in_the_stage_live_and_no_other() -> None:
    commands = {
        stage.name: " ".join(stage.commands) for stage in stages.stages(stages.arguments([]))
    }
    for path in stages.LIVE:
        assert (Path(__file__).parents[1] / path).exists()
        assert f" {path} " in commands["live"]
        assert f"--ignore={path} " in commands["python"]


@pytest.mark.parametrize(
    ("paths", "build"), [(stages.OF_IMAGES, "packages"), (stages.OF_SANITIZERS, "sanitizers")]
)
def test_tests_of_a_build_run_once_after_it(paths: tuple[str, ...], build: str) -> None:
    todo = stages.stages(stages.arguments([]))
    for path in paths:
        assert (Path(__file__).parents[1] / path).exists()
        (runs,) = (it for it in todo if any(f" {path}" in words for words in it.commands))
        assert runs.after == (build,)


@pytest.mark.parametrize("words", [[], ["--all"], ["--only", "vcan"]])
def test_every_stage_comes_after_those_that_it_needs(words: list[str]) -> None:
    seen: set[str] = set()
    for stage in stages.stages(stages.arguments(words)):
        assert set(stage.after) <= seen
        seen.add(stage.name)
    assert "vcan" in seen


def test_an_unknown_stage_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        stages.arguments(["--only", "nonsense"])
    assert "choose from lint, release, vcan" in capsys.readouterr().err
