# SPDX-License-Identifier: MIT
"""Compares the thrusts that a boat's slot needs with the limits of its propellers.

T_port = X/2 + N/2a        T_stbd = X/2 − N/2a        a half the distance between the two

A propeller's limit is γ T_max, as in `sil.plant.propeller`.
"""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from sil.certificate.slots import SlotMotion
from sil.plant.hull import Array
from sil.plant.propeller import PropellerParameters

Side = Literal["port", "stbd"]
Direction = Literal["forward", "reverse"]


@dataclass(frozen=True)
class ThrustNeed:
    """Extremes of both propellers, N, and the one nearest to its limit.

    `margin`: unused share of the limit of propeller `side` in `direction`, at `at_s` after the
    window's beginning; negative if the propeller cannot give the thrust, −∞ if it has no reverse.
    """

    least_N: float
    most_N: float
    margin: float
    side: Side
    direction: Direction
    at_s: float
    sway_N: float

    @property
    def given(self) -> bool:
        """Whether the propellers can give all thrusts, and the hull needs no sway force."""
        return self.margin >= 0.0 and self.sway_N < 1e-3


def thrust_need(slot: SlotMotion, propellers: PropellerParameters) -> ThrustNeed:
    """The thrusts that a slot needs from a boat's propellers."""
    thrust = thrusts(slot.tau, propellers.arm_m)
    gains = np.array([propellers.port_gain, propellers.stbd_gain])
    forward = thrust / (gains * propellers.forward_max_N)
    astern = thrust < -1e-9
    # a propeller that cannot reverse would need an infinite share of its limit
    with np.errstate(divide="ignore", invalid="ignore"):
        reverse = np.where(astern, -thrust / (gains * propellers.reverse_max_N), 0.0)
    used = np.maximum(forward, reverse)
    k, side = (int(i) for i in np.unravel_index(np.argmax(used), used.shape))
    times_s = slot.motion.times_s
    return ThrustNeed(
        least_N=float(thrust.min()),
        most_N=float(thrust.max()),
        margin=float(1.0 - used[k, side]),
        side="port" if side == 0 else "stbd",
        direction="reverse" if astern[k, side] else "forward",
        at_s=float(times_s[k] - times_s[0]),
        sway_N=slot.sway_N,
    )


def thrusts(tau: Array, arm_m: float) -> Array:
    """Thrusts (M, 2), port and starboard, N, that give wrenches (M, 2) in N, N m."""
    half_turn = 0.5 * tau[:, 1] / arm_m
    return np.column_stack([0.5 * tau[:, 0] + half_turn, 0.5 * tau[:, 0] - half_turn])
