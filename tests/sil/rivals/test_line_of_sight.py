# SPDX-License-Identifier: MIT
"""The rivals' laws alone, on a boat that does as its model says."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from sil.plant.hull import Array
from sil.rivals import rover
from sil.rivals.helm import Helm, Known, Seen, allocate, wrap
from sil.rivals.line_of_sight import Gains, LineOfSight
from sil.rivals.mpc import Mpc
from sil.rivals.path import Path
from tests.each_push import few

HULL = Known(24.0, 38.0, 5.5, 13.0, 70.0, 9.0, 0.29, 20.0)
STEP_S = 0.05


def straight(speed_mps: float = 0.5, seconds: float = 200.0) -> Path:
    """North, at a speed."""
    t_s = np.arange(0.0, seconds, 0.01)
    motion = np.zeros((t_s.size, 10))
    motion[:, 0], motion[:, 3] = speed_mps * t_s, speed_mps
    return Path(motion, 0.01)


def sailed(helm: Helm, seconds: float, current: tuple[float, float], weak: float = 1.0) -> Array:
    """Places of a boat that starts 2 m to starboard: SciPy's integrator, not the simulation's."""
    state = np.array([0.0, 2.0, 0.0, 0.0, 0.0, 0.0])  # place, heading, velocity through the water

    def rate(_: float, s: Array, port: float, stbd: float) -> list[float]:
        psi, u, v, r = s[2:]
        surge, yaw = port + stbd, HULL.arm_m * (port - stbd)
        return [
            u * math.cos(psi) - v * math.sin(psi) + current[0],
            u * math.sin(psi) + v * math.cos(psi) + current[1],
            r,
            (surge + HULL.m22 * v * r - HULL.d11 * u) / HULL.m11,
            (-HULL.m11 * u * r - HULL.d22 * v) / HULL.m22,
            (yaw - (HULL.m22 - HULL.m11) * u * v - HULL.d33 * r) / HULL.m33,
        ]

    places = []
    for k in range(round(seconds / STEP_S)):
        psi = state[2]
        cos, sin = math.cos(psi), math.sin(psi)
        u = state[3] + cos * current[0] + sin * current[1]
        v = state[4] - sin * current[0] + cos * current[1]
        x, y, r = state[0], state[1], state[5]
        port, stbd = helm.steer(Seen(k * STEP_S, x, y, wrap(psi), u, v, r))
        assert max(abs(port), abs(stbd)) <= HULL.most_N + 1e-6
        state = solve_ivp(rate, (0.0, STEP_S), state, args=(port, weak * stbd), rtol=1e-6).y[:, -1]
        places.append(state[:2])
    return np.array(places)


HELMS: dict[str, Callable[[Path], Helm]] = {
    "ILOS": lambda path: LineOfSight(HULL, path, Gains(1.0, 0.1, 2.0), adapts=False),
    "ALOS": lambda path: LineOfSight(HULL, path, Gains(1.0, 0.1, 2.0), adapts=True),
    "Rover": lambda path: rover.Rover(HULL, rover.on_path(path), rover.Gains(0.5, 1.0, 0.5)),
    "NMPC": lambda path: Mpc(HULL, path),
}


@pytest.mark.parametrize("name", few(HELMS, ["ALOS", "ILOS", "Rover"]))
def test_it_comes_to_the_path_in_a_current_with_a_weak_propeller(name: str) -> None:
    places = sailed(HELMS[name](straight()), 100.0, (0.05, 0.1), weak=0.85)
    assert abs(places[-1, 1]) < 0.15 and np.abs(places[-200:, 1]).max() < 0.2
    speed = (places[-1, 0] - places[-401, 0]) / 20.0
    assert speed == pytest.approx(0.5, abs=0.03)


@pytest.mark.parametrize("adapts", [False, True])
def test_without_learning_a_current_keeps_it_off_the_path(adapts: bool) -> None:
    """So the test above can fail."""
    helm = LineOfSight(HULL, straight(), Gains(1.0, 0.0, 2.0), adapts=adapts)
    assert abs(sailed(helm, 100.0, (0.05, 0.1), weak=0.85)[-1, 1]) > 0.1


def test_thrust_is_limited_and_yaw_comes_first() -> None:
    assert allocate(HULL, 4.0, 0.0) == (2.0, 2.0)
    assert allocate(HULL, 0.0, 2.9) == pytest.approx((5.0, -5.0))
    assert allocate(HULL, 1000.0, 2.9) == pytest.approx((20.0, 10.0))
    assert allocate(HULL, 1000.0, -1000.0) == (-20.0, 20.0)


def test_a_follower_extrapolates_its_leaders_last_message() -> None:
    heard = rover.Heard(0.1, lambda: False, 0.1)
    target = heard.follow((-3.0, 1.0))
    heard.say(Seen(1.0, 10.0, 5.0, math.pi / 2, 0.5, 0.0, 0.0))
    early = target(Seen(1.05, 7.0, 6.0, 0.0, 0.0, 0.0, 0.0))
    assert (early.x, early.y, early.vx) == (7.0, 6.0, 0.0)
    late = target(Seen(3.0, 7.0, 6.0, 0.0, 0.0, 0.0, 0.0))
    assert (late.x, late.y) == pytest.approx((7.0, 7.0))
    assert (late.vx, late.vy) == pytest.approx((0.0, 0.5))


def test_a_lost_message_is_not_received() -> None:
    heard = rover.Heard(0.0, lambda: True, 0.1)
    heard.say(Seen(1.0, 10.0, 5.0, 0.0, 0.5, 0.0, 0.0))
    assert heard.follow((0.0, 0.0))(Seen(2.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0)).x == 1.0


def test_the_path_does_not_leap_to_another_leg() -> None:
    t_s = np.arange(0.0, 120.0, 0.01)
    motion = np.zeros((t_s.size, 10))
    out = t_s < 60.0
    motion[:, 0] = np.where(out, 0.5 * t_s, 0.5 * (120.0 - t_s))
    motion[:, 2], motion[:, 3] = np.where(out, 0.0, math.pi), 0.5
    path = Path(motion, 0.01)
    for k in range(0, 5000, 100):
        at = path.beside(motion[k, 0], 0.3)
        assert abs(at.k - k) <= 1 and at.y_m == pytest.approx(0.3)
