# SPDX-License-Identifier: MIT
"""The motion and thrust that a slot demands: closed forms, and hulls that sail it."""

import numpy as np
import pytest

from sil.certificate.motion import Motion, Series, body_from_ground
from sil.certificate.slots import slot_motion
from sil.plant import hull
from sil.plant.hull import Array, HullParameters
from sil.scenario import scenario
from tests.sil.certificate.made_up import AT_REST, SINE, TURN, VESSEL, reference

LONG = HullParameters(2.0, 4.5, 1.4, 6.0, 30.0, 3.0, m23=0.2, crossflow=15.0, length_m=1.5)
HERE = np.zeros(2)


def test_hull_like_the_leaders_needs_the_leaders_input_anywhere_beside_it() -> None:
    motion = reference().motion
    slot = slot_motion(VESSEL, HERE, motion, np.array([-2.0, 3.0]), False)
    wanted = scenario.load("diamond").leader.tau(motion.times_s)
    np.testing.assert_allclose(slot.tau, wanted, atol=1e-6)
    shift = slot.motion.eta(motion.times_s) - motion.eta(motion.times_s)
    np.testing.assert_allclose(shift, np.tile([-2.0, 3.0, 0.0], (len(shift), 1)), atol=1e-6)


def test_boat_in_a_cross_current_heads_up_into_it_and_drives_through_the_water() -> None:
    motion, current = reference(SINE).motion, np.array([0.0, 0.1])
    speed = 2.0 / VESSEL.d11
    slot = slot_motion(VESSEL, current, motion, HERE, False)
    assert slot.motion.eta(np.zeros(1))[0, 2] == pytest.approx(-np.arctan2(0.1, speed), abs=1e-8)
    drag = VESSEL.d11 * np.hypot(speed, 0.1)
    np.testing.assert_allclose(slot.tau, [[drag, 0.0]], atol=1e-6)


def test_boat_on_a_slot_at_rest_in_a_current_heads_against_it() -> None:
    still = reference(*AT_REST).motion
    slot = slot_motion(VESSEL, np.array([0.0, 0.2]), still, HERE, False)
    assert np.sin(slot.motion.eta(np.zeros(1))[0, 2]) == pytest.approx(-1.0)
    np.testing.assert_allclose(slot.tau, [[0.2 * VESSEL.d11, 0.0]], atol=1e-6)


def test_boat_on_a_slot_at_rest_needs_nothing() -> None:
    still = reference(*AT_REST).motion
    slot = slot_motion(VESSEL, HERE, still, np.array([2.0, 1.0]), False)
    np.testing.assert_array_equal(slot.tau, [[0.0, 0.0]])
    assert slot.sway_N == 0.0


def test_slot_that_turns_with_the_leader_keeps_its_place_beside_it() -> None:
    motion = reference(*TURN).motion
    slot = slot_motion(VESSEL, HERE, motion, np.array([-1.5, 1.0]), True)
    times_s = np.linspace(0.0, 70.0, 40)
    there, lead = slot.motion.eta(times_s), motion.eta(times_s)
    seen = body_from_ground(lead[:, 2], there[:, :2] - lead[:, :2])
    np.testing.assert_allclose(seen, np.tile([-1.5, 1.0], (40, 1)), atol=1e-8)
    u, v, r = slot.motion.nu(times_s).T
    p = VESSEL
    np.testing.assert_allclose(p.m11 * u * r + p.d22 * v, 0.0, atol=1e-6)
    np.testing.assert_allclose(slot.tau[:, 0], p.d11 * u[0] - p.m22 * v[0] * r[0], atol=1e-6)


def sailed(parameters: HullParameters, current: Array, slot: Motion, tau: Array) -> Array:
    """Poses (K, 3), 10 ms apart, of a hull that starts on its slot, under the slot's wrench."""
    h_s, steps = 0.01, 400
    eta, nu = slot.eta(np.array([slot.begin_s])), slot.nu(np.array([slot.begin_s]))
    wrench = Series(slot.begin_s, slot.window_s, tau)
    poses = []
    for k in range(steps):
        stages = wrench.at(slot.begin_s + h_s * (k + np.array([0.0, 0.5, 1.0])))[:, None]
        water = (np.zeros((1, 3)), current[None], hull.stack([parameters]))
        hull.advance(eta, nu, stages, *water, h_s)
        poses.append(eta[0].copy())
    return np.array(poses)


@pytest.mark.parametrize("parameters", [VESSEL, LONG])
@pytest.mark.parametrize("turning", [False, True])
def test_hull_under_its_slots_wrench_sails_along_its_slot(
    parameters: HullParameters, turning: bool
) -> None:
    current, offset_m = np.array([0.06, -0.08]), np.array([-0.4, 0.3])
    slot = slot_motion(parameters, current, reference().motion, offset_m, turning)
    assert slot.sway_N < 1e-6
    poses = sailed(parameters, current, slot.motion, slot.tau)
    times_s = slot.motion.begin_s + 0.01 * np.arange(1, len(poses) + 1, dtype=float)
    np.testing.assert_allclose(poses, slot.motion.eta(times_s), atol=2e-4)
