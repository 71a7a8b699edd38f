# SPDX-License-Identifier: MIT
from tests.loop.late_radio import sailed


def test_no_boat_is_driven_by_states_that_are_older_than_the_limit() -> None:
    """The first of the thousand runs."""
    ended = [sailed(seed) for seed in range(1, 17)]
    assert not any(one.broke for one in ended)
    assert sum(one.driven_s > 0.0 for one in ended) >= 8


def test_a_wrong_known_latency_breaks_the_rule() -> None:
    assert any(sailed(seed, answers=False).broke for seed in range(1, 11))
