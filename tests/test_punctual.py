# SPDX-License-Identifier: MIT
"""Live runs are judged where the machine kept up, and only there."""

import json
from pathlib import Path

import pytest

from sil.lockstep.start import StartError
from tests.punctual import sail_punctually


def run(out: Path, overruns: int, end: Exception | None) -> None:
    """A run of one boat in which so many of 100 ticks were late."""
    (out / "boat1").mkdir(parents=True)
    stats = json.dumps({"overruns": overruns, "ticks": 100})
    (out / "boat1" / "stats.json").write_text(stats, encoding="utf-8")
    if end is not None:
        raise end


@pytest.mark.parametrize("end", [None, AssertionError(), StartError("not in FORMATION")])
def test_boats_that_were_late_twice_are_not_judged_whatever_they_did(
    end: Exception | None, tmp_path: Path
) -> None:
    with pytest.raises(pytest.skip.Exception, match=r"boat1 late in 9%.*, then boat1 late in 9%"):
        sail_punctually(lambda out: run(out, 9, end), tmp_path)


@pytest.mark.parametrize("end", [AssertionError(), StartError("not in FORMATION")])
def test_punctual_boats_that_fail_have_failed(end: Exception, tmp_path: Path) -> None:
    with pytest.raises(type(end)):
        sail_punctually(lambda out: run(out, 1, end), tmp_path)


def test_boats_that_were_late_once_sail_again(tmp_path: Path) -> None:
    late = iter([9, 1])
    found = sail_punctually(lambda out: run(out, next(late), None), tmp_path)
    assert found == tmp_path / "1"
