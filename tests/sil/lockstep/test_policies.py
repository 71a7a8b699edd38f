# SPDX-License-Identifier: MIT
"""A boat that breaks a rule of the firmware: its run fails and leaves its recording."""

from pathlib import Path

import flotilla
import pytest

from sil.campaign.run_outcome import result_of
from sil.cli.main import main
from sil.lockstep.policies import PolicyViolationError
from sil.lockstep.recording import Recording
from sil.lockstep.world import Run, World, sail
from sil.scenario import scenario

RULE = "HOLD: zeros within a tick"
SHORT = ["duration_s=0.5"]
AT_US = 2_340_000


class Disobedient(flotilla.Fleet):
    """A fleet that reports a broken rule of its last boat but one."""

    def violations(self) -> list[tuple[int, int, str]]:
        return [(len(self.states) - 1, AT_US, RULE)]


@pytest.fixture
def disobedient(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(flotilla, "Fleet", Disobedient)


def test_rules_have_names_and_there_are_at_least_sixty() -> None:
    names = [name for _, name in flotilla.policies()]
    assert len(names) == len(set(names)) >= 60
    assert RULE in names


@pytest.mark.usefixtures("disobedient")
def test_a_run_names_boat_time_rule_and_the_recording_which_is_kept(tmp_path: Path) -> None:
    recording = tmp_path / "recording.bin"
    world = World(scenario.load("diamond", SHORT), {})
    with pytest.raises(PolicyViolationError) as caught:
        world.run(recording, lambda _: None)
    for word in ("boat 3", "2.340 s", RULE, str(recording)):
        assert word in str(caught.value)
    assert max(t_us for t_us, _, _ in Recording(recording)) >= AT_US


@pytest.mark.usefixtures("disobedient")
def test_a_broken_rule_fails_only_its_own_run_among_those_sailed_together() -> None:
    chosen = scenario.load("diamond", SHORT)
    good, bad = sail([chosen, chosen], {})
    assert isinstance(good, Run)
    assert isinstance(bad, PolicyViolationError)
    left = result_of(1, chosen, bad)
    assert left.outcome == "failed"
    assert RULE in left.reason


@pytest.mark.usefixtures("disobedient")
def test_a_broken_rule_ends_the_command_with_one_line_and_status_1(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", "diamond", "--set", SHORT[0], "--out", str(tmp_path)]) == 1
    told = capsys.readouterr().err
    assert told.startswith("error: boat 3 broke a rule at t = 2.340 s")
    assert str(tmp_path / "recording.bin") in told
