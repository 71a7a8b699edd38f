# SPDX-License-Identifier: MIT
"""Nine of the thousand losses, of most kinds; python -m tests.loop.failsafes sails them all."""

from tests.loop.failsafes import draw, expected, sail_all


def test_boats_that_lose_something_at_any_instant_end_as_their_parameters_say() -> None:
    ended = sail_all(range(3, 12))
    assert not [(one.drawn.seed, one.wrong) for one in ended if one.wrong]
    assert {"LOITER", "RTL", "HOLD"} <= {name for one in ended for name in one.names}


def test_the_judge_notices_a_run_without_its_fault() -> None:
    """The judge's own test: without the fault the boats do not end where they should."""
    one = next(draw(seed) for seed in range(1, 100) if draw(seed).loss == "battery")
    assert one.scenario.fault
    assert expected(one, one.boat) == {one.stop}
