# SPDX-License-Identifier: MIT
"""Two propellers: curve, saturation, lag, force and moment, shaft speed."""

from dataclasses import replace

import numpy as np
import pytest

from sil.plant import propeller
from sil.plant.hull import Array
from sil.plant.propeller import PropellerParameters

IDEAL = PropellerParameters(
    arm_m=0.25, forward_max_N=50.0, reverse_max_N=30.0, expo=0.0, lag_s=0.0, rpm_max=3000.0
)
H_S = 0.01


def run(
    pair: PropellerParameters,
    command: list[float],
    start: list[float] | None = None,
    steps: int = 1,
) -> tuple[Array, Array]:
    """Thrust [port stbd] after the steps and tau (3, [X N]) during the last one."""
    thrust, tau = np.array([start or [0.0, 0.0]]), np.zeros((3, 1, 2))
    for _ in range(steps):
        propeller.advance(thrust, np.array([command]), tau, propeller.stack([pair]), H_S)
    return thrust[0], tau[:, 0]


def with_lag(lag_s: float) -> PropellerParameters:
    return PropellerParameters(
        arm_m=0.25, forward_max_N=50.0, reverse_max_N=30.0, expo=0.0, lag_s=lag_s
    )


def test_port_thrust_turns_the_boat_to_starboard() -> None:
    _, tau = run(IDEAL, [0.2, 0.0])
    np.testing.assert_allclose(tau, [[10.0, 2.5]] * 3)


def test_equal_thrust_drives_the_boat_straight_ahead() -> None:
    _, tau = run(IDEAL, [0.1, 0.1])
    np.testing.assert_allclose(tau, [[10.0, 0.0]] * 3)


def test_propeller_without_lag_gives_the_commanded_thrust_at_once_and_for_the_whole_step() -> None:
    thrust, tau = run(IDEAL, [0.4, -0.5], start=[-7.0, 9.0])
    np.testing.assert_allclose(thrust, [20.0, -15.0])
    np.testing.assert_allclose(tau, [[5.0, 8.75]] * 3)


def test_command_beyond_full_scale_gives_the_maximum_of_its_direction() -> None:
    thrust, _ = run(IDEAL, [1.7, -1.7])
    np.testing.assert_allclose(thrust, [50.0, -30.0])


def test_each_side_gives_its_own_share_at_the_same_shaft_speed() -> None:
    pair = replace(IDEAL, port_gain=0.8, stbd_gain=1.1)
    thrust, tau = run(pair, [0.4, -0.5])
    np.testing.assert_allclose(thrust, [16.0, -16.5])
    np.testing.assert_allclose(tau[0], [-0.5, 0.25 * 32.5])
    rpm = np.zeros((1, 2))
    propeller.shaft_speed(thrust[None], propeller.stack([pair]), rpm)
    np.testing.assert_allclose(rpm[0], 3000.0 * np.sqrt([0.4, 0.5]) * [1, -1])


@pytest.mark.parametrize("expo", [0.0, 0.4, 1.0])
@pytest.mark.parametrize("command", [-1.0, -0.3, 0.0, 0.3, 1.0])
def test_thrust_curve_lies_between_linear_and_quadratic(expo: float, command: float) -> None:
    pair = PropellerParameters(0.25, 50.0, 30.0, expo, 0.0)
    limit = 50.0 if command >= 0.0 else 30.0
    linear, quadratic = limit * command, limit * command * abs(command)
    thrust, _ = run(pair, [command, -command])
    assert thrust[0] == pytest.approx((1.0 - expo) * linear + expo * quadratic)


def test_boat_feels_the_lag_at_the_start_middle_and_end_of_the_step() -> None:
    thrust, tau = run(with_lag(0.05), [1.0, 1.0], start=[10.0, 10.0])
    port = 50.0 - 40.0 * np.exp(-np.array([0.0, 0.5, 1.0]) * H_S / 0.05)
    np.testing.assert_allclose(tau[:, 0], 2.0 * port)
    np.testing.assert_allclose(thrust, port[-1])


def test_lagging_propeller_reaches_63_percent_after_its_time_constant() -> None:
    thrust, _ = run(with_lag(0.1), [1.0, -1.0], steps=10)
    np.testing.assert_allclose(thrust, np.array([50.0, -30.0]) * (1.0 - np.exp(-1.0)))


def test_each_boat_has_its_own_propellers() -> None:
    pairs = propeller.stack([IDEAL, with_lag(0.1)])
    thrust, tau = np.zeros((2, 2)), np.zeros((3, 2, 2))
    propeller.advance(thrust, np.ones((2, 2)), tau, pairs, H_S)
    np.testing.assert_allclose(thrust[:, 0], [50.0, 50.0 * (1.0 - np.exp(-0.1))])


def test_shaft_speed_grows_with_the_root_of_the_thrust_and_has_its_sign() -> None:
    rpm = np.zeros((2, 2))
    thrust = np.array([[50.0, -30.0], [12.5, 0.0]])
    propeller.shaft_speed(thrust, propeller.stack([IDEAL, IDEAL]), rpm)
    np.testing.assert_allclose(rpm, [[3000.0, -3000.0], [1500.0, 0.0]])


def test_propeller_that_cannot_reverse_stands_still_astern() -> None:
    ahead_only = propeller.stack([PropellerParameters(0.25, 50.0, 0.0, 0.0, 0.0)])
    thrust, tau, rpm = np.zeros((1, 2)), np.zeros((3, 1, 2)), np.ones((1, 2))
    propeller.advance(thrust, np.full((1, 2), -1.0), tau, ahead_only, H_S)
    propeller.shaft_speed(thrust, ahead_only, rpm)
    assert not thrust.any() and not tau.any() and not rpm.any()


def test_command_within_the_dead_band_leaves_the_propeller_at_rest() -> None:
    pair = replace(IDEAL, dead=0.1)
    thrust, _ = run(pair, [0.09, -0.09])
    np.testing.assert_allclose(thrust, [0.0, 0.0])
    thrust, _ = run(pair, [0.1, -0.1])  # beyond it the curve is the same
    np.testing.assert_allclose(thrust, [5.0, -3.0])
