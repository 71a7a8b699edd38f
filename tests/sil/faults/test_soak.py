# SPDX-License-Identifier: MIT
"""A soak depends only on its seed, recovers from every fault, and reports failures."""

import pytest

from sil.cli.main import main
from sil.faults import soak
from sil.faults.soak import Soaked
from sil.faults.watch import STATES
from sil.lockstep.policies import PolicyViolationError

MINUTES = 4.0


def soaked(seed: int) -> Soaked:
    return soak.soak(MINUTES / 60.0, seed, lambda *_: None)


def test_every_fault_is_recovered_from_and_a_seed_makes_the_history() -> None:
    one, again, other = soaked(1), soaked(1), soaked(2)
    assert not one.wrong and not other.wrong
    assert one.faults.total() > 10
    assert (one.digest, one.faults, one.slowest_s) == (again.digest, again.faults, again.slowest_s)
    assert one.digest != other.digest


def test_a_soak_too_short_for_a_fault_fails(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["faults", "--soak", "1e-5"]) == 1
    said = capsys.readouterr().out
    assert "no fault happened in 1e-05 h" in said and said.endswith("0 passed, 1 failed\n")


def test_a_fault_that_is_not_recovered_from_ends_the_soak(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(soak, "RECOVERED_S", 1.0)
    monkeypatch.setattr(soak, "ask", lambda *_: None)
    history = soaked(1)
    assert "not recovered by" in history.wrong[0]


def test_forbidden_thrust_ends_the_soak(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(soak, "OFF", [STATES["FORMATION"]])
    assert "forbidden thrust" in soaked(1).wrong[0]


def test_a_broken_rule_ends_the_soak(monkeypatch: pytest.MonkeyPatch) -> None:
    broken = {0: PolicyViolationError('boat 3 broke a rule at t = 2.340 s: "it"')}
    monkeypatch.setattr(soak, "violations", lambda _: broken)
    assert soaked(1).wrong == [str(broken[0])]
