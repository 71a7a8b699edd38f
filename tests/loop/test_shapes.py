# SPDX-License-Identifier: MIT
"""A few of the changes of `python -m tests.loop.shapes`."""

import numpy as np
import pytest

from tests.loop.shapes import drawn, intercept_s, sail

GUARD_M = 1.2 * 1.2  # of lead's boats


@pytest.mark.parametrize(("boats", "turns"), [(4, True), (8, False)])
def test_boats_change_their_shape_under_way_and_none_comes_too_near(
    boats: int, *, turns: bool
) -> None:
    changes = sail(boats, 1, seed=1, turns=turns)
    assert sum(it.far_m > 5 for it in changes) >= 3
    for it in changes:
        assert it.nearest_m > GUARD_M
        assert it.idle == 0 and it.off_m < 0.3
        assert it.arrived_s <= it.asked_s  # 1 % of the changes are late, see FLEET.md


def test_an_intercept_is_where_boat_and_place_meet() -> None:
    generator = np.random.default_rng(3)
    to = generator.uniform(-50, 50, (100, 2))
    v = generator.uniform(-1, 1, (100, 2))
    t = intercept_s(to, v)
    assert np.hypot(*(to + t[:, None] * v).T) == pytest.approx(1.5 * t)


def test_a_shape_that_is_drawn_has_the_leader_at_its_place() -> None:
    generator = np.random.default_rng(5)
    assert all(drawn(generator, boats).places[0] == (0, 0) for boats in range(4, 21))
