# SPDX-License-Identifier: MIT
"""Propellers near their limits: which one, in which direction, how much is left."""

import numpy as np
import pytest

from sil.certificate.motion import motion_of
from sil.certificate.slots import SlotMotion
from sil.certificate.thrust import ThrustNeed, thrust_need, thrusts
from sil.plant.hull import Array
from sil.plant.propeller import PropellerParameters


def need(tau: Array, forward_N: float, reverse_N: float, sway_N: float = 0.0) -> ThrustNeed:
    motion = motion_of(5.0, 8.0, np.zeros((len(tau) + 1, 3)), np.zeros((len(tau), 3)))
    pair = PropellerParameters(0.25, forward_N, reverse_N, 0.0, 0.0)
    return thrust_need(SlotMotion(motion, tau, sway_N), pair)


def test_thrusts_add_up_to_the_wrench() -> None:
    tau = np.array([[2.0, 0.3], [-1.0, 0.5]])
    port, stbd = thrusts(tau, 0.25).T
    np.testing.assert_allclose(np.column_stack([port + stbd, 0.25 * (port - stbd)]), tau)


def test_turn_to_port_is_limited_by_the_starboard_propeller() -> None:
    found = need(np.array([[2.0, 0.0], [2.0, -0.3]]), 2.0, 2.0)
    assert (found.side, found.direction, found.at_s) == ("stbd", "forward", 4.0)
    assert found.margin == pytest.approx(0.2) and found.given
    assert (found.least_N, found.most_N) == pytest.approx((0.4, 1.6))


def test_weak_reverse_thrust_is_named_as_the_limit() -> None:
    found = need(np.array([[0.0, 0.5]]), 2.0, 0.8)
    assert (found.side, found.direction) == ("stbd", "reverse")
    assert found.margin == pytest.approx(1.0 - 1.0 / 0.8) and not found.given


def test_propeller_that_cannot_reverse_gives_no_reverse() -> None:
    assert need(np.array([[0.0, 0.5]]), 2.0, 0.0).margin == -np.inf
    assert need(np.array([[2.0, 0.1]]), 2.0, 0.0).given


def test_weaker_propeller_is_nearer_to_its_limit() -> None:
    motion = motion_of(5.0, 8.0, np.zeros((2, 3)), np.zeros((1, 3)))
    pair = PropellerParameters(0.25, 2.0, 2.0, 0.0, 0.0, port_gain=0.9, stbd_gain=0.6)
    ahead, astern = (SlotMotion(motion, np.array([[x, 0.0]]), 0.0) for x in (1.8, -1.8))
    for slot, direction in ((ahead, "forward"), (astern, "reverse")):
        found = thrust_need(slot, pair)
        assert (found.side, found.direction) == ("stbd", direction)
        assert found.margin == pytest.approx(1.0 - 0.9 / (0.6 * 2.0))


def test_slot_that_needs_a_force_abeam_is_not_given() -> None:
    assert not need(np.array([[1.0, 0.0]]), 2.0, 2.0, sway_N=0.1).given


def test_slot_at_rest_leaves_all_thrust() -> None:
    assert need(np.array([[0.0, 0.0]]), 2.0, 1.0).margin == 1.0
