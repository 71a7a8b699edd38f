# SPDX-License-Identifier: MIT
"""The linearisation over a window: its instants, its products, and their limits."""

import numpy as np
import pytest

from sil.certificate import monodromy
from sil.certificate.loop import BODY, COMPONENTS, Loop, leader_rows
from sil.scenario.law import LAWS
from tests.sil.certificate.made_up import AT_REST, SINE, TURN, boat
from tests.turns import some


def test_number_of_windows_is_the_one_nearest_to_whole_ticks() -> None:
    where = monodromy.instants(boat(), 500)
    # 2094.395 ticks: five periods miss by 0.02, fewer by 0.19 and more
    assert (where.windows, where.length) == (5, 10472)
    assert where.cycles.sum() == 10472 and len(where.ticks) == 500
    one = monodromy.instants(boat(), 48, windows=1)
    assert (one.windows, one.length) == (1, 2094)


def test_instants_fall_where_a_cycle_of_fixes_begins() -> None:
    slow = boat("navigation.rate_hz=30.0")
    where = monodromy.instants(slow, 40, windows=1)
    assert not np.any(where.ticks % 10)
    assert where.length == 10 * where.cycles.sum()
    assert all(slow.fix_due(int(tick)) for tick in some(where.ticks))


def test_straight_leg_is_examined_at_one_instant() -> None:
    where = monodromy.instants(boat(SINE), 500)
    assert (len(where.ticks), where.cycles.tolist(), where.length) == (1, [100], 100)


def test_linearised_boat_predicts_the_effect_of_a_nudge() -> None:
    boat_1 = boat(*TURN, law="product")
    where = monodromy.instants(boat_1, 100_000, windows=1)
    start = monodromy.on_slot(boat_1, where)
    few = monodromy.Points(start.ticks[:200], start.cycles[:200], start.states[:200])
    # along one way, not from one slot to the next
    loop, rows = Loop(boat_1, 1), []
    loop.resume(int(few.ticks[0]), few.states[:1])
    times_s = boat_1.h_s * np.array(few.ticks, dtype=np.float64)
    for row in leader_rows(boat_1.leader, times_s):
        rows.append(loop.state[0])
        loop.step(row)
    ways = monodromy.Points(few.ticks, few.cycles, np.array(rows))
    partial, scale = monodromy.products(monodromy.jacobians(boat_1, ways), ways.cycles)

    nudge = np.zeros(len(rows[0]))
    nudge[:6] = 1e-4 * np.array([1.0, -1.0, 0.5, 0.2, 0.4, -0.3])
    nudged = Loop(boat_1, 1)
    nudged.resume(int(few.ticks[0]), few.states[:1] + nudge)
    for row in leader_rows(boat_1.leader, times_s):
        nudged.step(row)
    moved = (nudged.state - loop.state)[0]
    assert scale == 0.0
    np.testing.assert_allclose(partial[-1] @ nudge, moved, atol=2e-7)


def test_product_of_a_runaway_loop_does_not_overflow() -> None:
    factors = np.array([np.diag([1e20, 0.5])])
    partial, scale = monodromy.products(factors, np.array([100]))
    assert np.isfinite(partial).all()
    largest = np.log(np.abs(np.linalg.eigvals(partial[-1])).max()) + scale
    assert largest == pytest.approx(2000.0 * np.log(10.0))


def test_memory_that_is_never_written_is_not_part_of_the_state() -> None:
    factors = np.array([[[0.9, 0.3, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]] * 2)
    factors[1, 2, 0] = 0.1
    assert monodromy.written(factors).tolist() == [True, False, True]


def test_boat_forgets_estimates_whose_bandwidth_is_0_at_once() -> None:
    where = monodromy.instants(boat(SINE), 1)
    estimates = [
        k for k, name in enumerate(COMPONENTS) if name.split()[0] in ("unknown", "current")
    ]
    kept = {}
    for law in LAWS:
        boat_1 = boat(SINE, law=law)
        (factor,) = monodromy.jacobians(boat_1, monodromy.on_slot(boat_1, where))
        kept[law] = np.abs(factor[estimates]).max(axis=1) > 0.0
    assert len(estimates) == 5
    assert kept["product"].all() and not kept["paper"].any()


def test_mode_that_does_not_move_the_boat_is_not_visible() -> None:
    n = BODY
    product = np.diag([*[0.5] * n, 1.0, 1.0])
    product[0, n] = 1.0  # moves the boat
    values, vectors = np.linalg.eig(product)
    # any mixture of the two on 1 is a pair of eigenvectors, too
    mixture = vectors.astype(complex)
    mixture[:, n + 1] = vectors[:, n + 1] + vectors[:, n]
    seen = monodromy.visible(values.astype(complex), mixture, product[None])
    assert seen[:n].all() and seen[n:].sum() == 1


def test_boat_that_leaves_its_slot_is_linearised_on_it() -> None:
    fast = boat("rate_hz=50.0", "navigation.rate_hz=50.0", changed={"LAW_KDR": 200.0})
    where = monodromy.instants(fast, 10, windows=1)
    regime = monodromy.settle(fast, [where])
    assert not regime.steady and regime.limited
    on_slot = monodromy.on_slot(fast, where)
    np.testing.assert_array_equal(regime.points[0].states, on_slot.states)


def test_boat_behind_a_leader_at_rest_stays_where_it_is() -> None:
    still = boat(*AT_REST)
    regime = monodromy.settle(still, [monodromy.instants(still, 10)])
    assert regime.steady and not regime.error.any()
