# SPDX-License-Identifier: MIT
"""Two propellers a boat: command → thrust curve → first-order lag → surge force and yaw moment.

T = γ T_max ((1 − ε) c + ε c |c|), T_max the maximum of the direction of c; lag × Ṫ_now = T − T_now;
X = T_port + T_stbd, N = a (T_port − T_stbd): port thrust turns the boat to starboard.
"""

from collections.abc import Iterable
from dataclasses import astuple, dataclass

import numpy as np
from numba import njit

from sil.plant.hull import Array


@dataclass(frozen=True)
class PropellerParameters:
    """The pair of one boat: half the distance between them, limits of each, curve, lag, speed."""

    arm_m: float
    forward_max_N: float
    reverse_max_N: float
    expo: float  # ε: 0 linear … 1 quadratic
    lag_s: float  # 0: thrust follows the command at once
    rpm_max: float = 3600.0  # at the maximum thrust of either direction
    port_gain: float = 1.0  # γ
    stbd_gain: float = 1.0


def stack(pairs: Iterable[PropellerParameters]) -> Array:
    """Parameters (n, 8) of n boats, columns in the order of `PropellerParameters`."""
    return np.array([astuple(pair) for pair in pairs], dtype=np.float64)


@njit(cache=True)
def advance(thrust: Array, command: Array, tau: Array, parameters: Array, h_s: float) -> None:
    """Carry the thrust of n boats over one step of `h_s` seconds, the command held; in place.

    Shapes: thrust (n, 2) and command (n, 2), columns port, stbd, in N and in [−1, 1] (clamped);
    parameters (n, 8) from `stack`. Writes tau (3, n, 2): [X N] (N, N m) at the start, the
    middle and the end of the step, as `hull.advance` takes it. The lag is integrated exactly.
    """
    for i in range(thrust.shape[0]):
        arm, lag_s = parameters[i, 0], parameters[i, 4]
        half_decay = np.exp(-0.5 * h_s / lag_s) if lag_s > 0.0 else 0.0
        port_end = parameters[i, 6] * _steady_thrust(command[i, 0], parameters[i])
        stbd_end = parameters[i, 7] * _steady_thrust(command[i, 1], parameters[i])
        port_gap = thrust[i, 0] - port_end if lag_s > 0.0 else 0.0
        stbd_gap = thrust[i, 1] - stbd_end if lag_s > 0.0 else 0.0
        for stage in range(3):
            port, stbd = port_end + port_gap, stbd_end + stbd_gap
            tau[stage, i, 0] = port + stbd
            tau[stage, i, 1] = arm * (port - stbd)
            thrust[i, 0], thrust[i, 1] = port, stbd
            port_gap *= half_decay
            stbd_gap *= half_decay


@njit(cache=True)
def shaft_speed(thrust: Array, parameters: Array, rpm: Array) -> None:
    """Write the shaft speeds (n, 2) in rpm, signed, that give `thrust` (n, 2) N: |n| ∝ √|T|."""
    for i in range(thrust.shape[0]):
        for side in range(2):
            now = thrust[i, side] / parameters[i, 6 + side]
            limit = parameters[i, 1] if now >= 0.0 else parameters[i, 2]
            # limit 0: a propeller that cannot reverse
            speed = parameters[i, 5] * np.sqrt(abs(now) / limit) if limit > 0.0 else 0.0
            rpm[i, side] = speed if now >= 0.0 else -speed


@njit(cache=True)
def _steady_thrust(command: float, p: Array) -> float:
    c = min(max(command, -1.0), 1.0)
    limit = p[1] if c >= 0.0 else p[2]
    thrust: float = limit * ((1.0 - p[3]) * c + p[3] * c * abs(c))
    return thrust
