# SPDX-License-Identifier: MIT
"""Coverage limits, which are missed if nothing was counted."""

from __future__ import annotations

import pytest

from tests.coverage import SUPERVISOR, Count, Coverage, failures


def covered(lines: int, branches: int, mcdc: int = 100) -> Coverage:
    """Coverage of that many of 100 lines, branches and MC/DC pairs."""
    return Coverage(Count(lines, 100), Count(branches, 100), Count(mcdc, 100))


def files(**changes: Coverage) -> dict[str, Coverage]:
    good = {"core": covered(100, 100), "link": covered(95, 90), "app": covered(95, 90)}
    names = {"core": SUPERVISOR, "link": "link/it.cpp", "app": "app/it.cpp"}
    return {names[room]: one for room, one in (good | changes).items()}


def test_coverage_at_its_limits_passes() -> None:
    assert failures(files()) == []


@pytest.mark.parametrize(
    ("room", "one", "words"),
    [
        ("core", covered(99, 100), "core: lines 99.0 %"),
        ("core", covered(100, 99), "core: branches 99.0 %"),
        ("core", covered(100, 100, 99), "MC/DC is not complete"),
        ("link", covered(94, 90), "link: lines 94.0 %"),
        ("app", covered(95, 89), "app: branches 89.0 %"),
    ],
)
def test_coverage_below_its_limit_is_reported(room: str, one: Coverage, words: str) -> None:
    (sentence,) = failures(files(**{room: one}))
    assert words in sentence


def test_parts_that_were_not_counted_are_not_covered() -> None:
    told = " ".join(failures({}))
    for words in ("core: nothing", "link: nothing", "app: nothing", "MC/DC is not complete"):
        assert words in told
    bare = Coverage(Count(9, 9), Count(9, 9), Count())
    assert failures(files(core=bare)) == [f"{SUPERVISOR}: MC/DC is not complete"]
