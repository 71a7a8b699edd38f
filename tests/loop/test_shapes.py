# SPDX-License-Identifier: MIT
"""A few of the changes of `python -m tests.loop.shapes`."""

import numpy as np
import pytest

from tests.loop import shapes
from tests.loop.shapes import EACH, STEP_S, drawn, from_shape, in_shape, intercepted_s, sail

GUARD = 1.2  # FS_SEP_M's default, in hull lengths


@pytest.mark.parametrize(
    ("boats", "turns", "hull", "length_m", "late", "seed", "each"),
    [
        (4, True, "", 1.2, 0, 3, 3),
        (8, False, "", 1.2, 0, 1, 3),
        pytest.param(4, True, "", 1.2, 0, 1, EACH, marks=pytest.mark.nightly),
        pytest.param(8, False, "", 1.2, 0, 1, EACH, marks=pytest.mark.nightly),
        pytest.param(6, False, "otter", 2.0, 1, 1, EACH, marks=pytest.mark.nightly),
    ],
)
def test_boats_change_their_shape_under_way_and_none_comes_too_near(
    boats: int,
    hull: str,
    length_m: float,
    late: int,
    seed: int,
    each: int,
    monkeypatch: pytest.MonkeyPatch,
    *,
    turns: bool,
) -> None:
    monkeypatch.setattr(shapes, "EACH", each)
    changes = sail(boats, 1, seed=seed, turns=turns, hull=hull)
    assert len(changes) == each
    assert sum(it.far_m > 5 for it in changes) >= 3
    for it in changes:
        assert it.nearest_m > GUARD * length_m
        assert it.idle == 0 and it.off_m < 0.3
        assert it.arrived_s < np.inf
    assert sum(it.arrived_s > it.asked_s for it in changes) <= late  # FLEET.md counts them


def test_an_intercept_is_where_boat_and_place_meet() -> None:
    generator = np.random.default_rng(3)
    t_s = np.arange(1000) * STEP_S
    for _ in range(20):
        begin, v = generator.uniform(-50, 50, 2), generator.uniform(-0.7, 0.7, 2)
        place = begin + t_s[:, None] * v + 5 * np.sin(0.1 * t_s)[:, None]
        met_s = intercepted_s(place[:, None], np.zeros((1, 2)))
        away = np.hypot(*place.T)
        assert away[round(met_s / STEP_S)] == pytest.approx(1.5 * met_s, abs=0.5)
        assert (away > 1.5 * t_s)[t_s < met_s - 0.1].all()
    never = np.stack([10 + 2 * t_s, 0 * t_s], -1)
    assert intercepted_s(never[:, None], np.zeros((1, 2))) == np.inf


def test_from_shape_is_the_inverse_of_in_shape() -> None:
    generator = np.random.default_rng(4)
    off, v = generator.normal(size=(50, 3, 2)), generator.normal(size=(50, 2))
    there = in_shape(off, v, turns=True)
    assert from_shape(there, v, turns=True) == pytest.approx(off)
    assert (from_shape(off, v, turns=False) == off).all()


def test_a_shape_that_is_drawn_has_the_leader_at_its_place() -> None:
    generator = np.random.default_rng(5)
    assert all(drawn(generator, boats).places[0] == (0, 0) for boats in range(4, 21))
