# SPDX-License-Identifier: MIT
"""With all extensions off, a boat is controlled exactly by the published law."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest

from tests.target.bus import FULL_SCALE
from tests.target.course import Course, wrap
from tests.target.hull import ARM_M, D11, D22, D33, M11, M22, M33
from tests.target.sea import PAPER, Sea
from tests.target.stations import FORMATION

GREATEST_N = 100.0  # so that no propeller reaches its limit
SLOT = (-1.5, 0.8)
M, D = np.diag([M11, M22, M33]), np.diag([D11, D22, D33])
G = np.array([[1.0, 0.0], [0.0, 0.0], [0.0, 1.0]])  # surge and yaw are actuated
K_D = np.diag([PAPER["LAW_KDU"], 0.0, PAPER["LAW_KDR"]])
K_X, K_PSI = PAPER["LAW_KX"], PAPER["LAW_KPSI"]


class Published:
    """Wang and Loría, for a leader whose body velocity is constant."""

    def __init__(self, leader: Course) -> None:
        self.v_star = leader.v

    def commands(self, own: Course, leader: Course) -> np.ndarray:
        """The commands to both propellers; advances v* by 0.01 s."""
        c, s = math.cos(own.psi), math.sin(own.psi)
        to_body = np.array([[c, s], [-s, c]])
        way = [own.north - leader.north - SLOT[0], own.east - leader.east - SLOT[1]]
        e_x, e_y = to_body @ way
        e_psi = wrap(own.psi - leader.psi)
        e_x_dot = own.r * e_y + own.u - leader.u * math.cos(e_psi) - leader.v * math.sin(e_psi)
        e_psi_dot = own.r - leader.r
        u_star = leader.u - K_X * e_x  # (eq:49a)
        r_star = leader.r - K_PSI * math.tanh(e_psi)  # (eq:49b)
        nu, nu_star = np.array([own.u, own.v, own.r]), np.array([u_star, self.v_star, r_star])
        v_star_dot = -(M11 * u_star * r_star + D22 * self.v_star) / M22  # (eq:mas-constraint)
        nu_star_dot = [-K_X * e_x_dot, v_star_dot, -K_PSI * e_psi_dot / math.cosh(e_psi) ** 2]
        C = np.zeros((3, 3))
        C[0, 2], C[1, 2] = -M22 * own.v, M11 * own.u
        C -= C.T
        tau = np.linalg.pinv(G) @ (
            M @ nu_star_dot + C @ nu_star + D @ nu_star - K_D @ (nu - nu_star)
        )
        rest = -(M11 / D22) * u_star * r_star  # where v* would end
        self.v_star = rest + (self.v_star - rest) * math.exp(-D22 / M22 * 0.01)
        thrust = np.linalg.solve([[1.0, 1.0], [ARM_M, -ARM_M]], tau)
        assert np.all(np.abs(thrust) < GREATEST_N)
        return FULL_SCALE * thrust / GREATEST_N


def somewhere(dice: random.Random) -> Course:
    def within(most: float) -> float:
        return dice.uniform(-most, most)

    return Course(within(5), within(5), within(3.1), within(1), within(0.2), within(0.4))


@pytest.mark.parametrize("scalar", ["float", "double"])
@pytest.mark.parametrize("seed", range(10))
def test_from_the_first_driven_tick_on_the_commands_are_the_published_laws(
    seed: int, scalar: str
) -> None:
    """Both states are exact and without latency, at 100 Hz."""
    dice = random.Random(seed)
    limits = {"THR_FWD_MAX": GREATEST_N, "THR_REV_MAX": GREATEST_N, "THR_SLEW": 0.0}
    slot = {"FORM_OFS_N": SLOT[0], "FORM_OFS_E": SLOT[1]}
    sea = Sea(PAPER | limits | slot, own=somewhere(dice), leader=somewhere(dice), scalar=scalar)
    sea.own.period_us = sea.leader.period_us = sea.period_us
    sea.enter_hold()
    sea.run(0.3)
    assert not any(sea.commands)
    law = Published(sea.leader.course)
    for tick in [sea.mode(FORMATION), *sea.run(0.5)]:
        now_us = tick.now_us
        wanted = law.commands(sea.own.truth(now_us), sea.leader.truth(now_us))
        assert tick.commands == pytest.approx(wanted, abs=0.6), now_us
    assert sea.state == "FORMATION"
