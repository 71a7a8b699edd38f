# SPDX-License-Identifier: MIT
"""A boat's two propellers: command → thrust curve → first-order lag → surge force, yaw moment.

T = γ T_max ((1 − ε) c + ε c |c|), 0 where |c| < dead, T_max the maximum of the direction of c;
lag × Ṫ_now = T − T_now;
X = T_port + T_stbd, N = a (T_port − T_stbd): port thrust turns the boat to starboard.
"""

from collections.abc import Iterable
from dataclasses import astuple, dataclass

import numpy as np
from flotilla import kernels

from sil.plant.hull import Array


@dataclass(frozen=True)
class PropellerParameters:
    """The pair of one boat: half the distance between them, limits of each, curve, lag, speed."""

    arm_m: float
    forward_max_N: float
    reverse_max_N: float
    expo: float  # ε: 0 linear … 1 quadratic
    lag_s: float  # 0: thrust follows the command without lag
    rpm_max: float = 3600.0  # at the maximum thrust of either direction
    port_gain: float = 1.0  # γ
    stbd_gain: float = 1.0
    dead: float = 0.0  # smaller commands leave the propeller at rest


def stack(pairs: Iterable[PropellerParameters]) -> Array:
    """Parameters (n, 9) of n boats, columns in the order of `PropellerParameters`."""
    return np.array([astuple(pair) for pair in pairs], dtype=np.float64)


def advance(thrust: Array, command: Array, tau: Array, parameters: Array, h_s: float) -> None:
    """Carry the thrust of n boats over one step of `h_s` seconds, the command held; in place.

    Shapes: thrust (n, 2) and command (n, 2), columns port, stbd, in N and in [−1, 1] (clamped);
    parameters (n, 9) from `stack`. Writes tau (3, n, 2): [X N] (N, N m) at the start, the
    middle and the end of the step, as `hull.advance` takes it. The lag is integrated exactly.
    """
    kernels.advance_propellers(thrust, command, tau, parameters, h_s)


def shaft_speed(thrust: Array, parameters: Array, rpm: Array) -> None:
    """Write the shaft speeds (n, 2) in rpm, signed, that give `thrust` (n, 2) N: |n| ∝ √|T|."""
    kernels.shaft_speeds(thrust, parameters, rpm)
