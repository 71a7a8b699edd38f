# SPDX-License-Identifier: MIT
"""The noise of a boat's own fixes that passes directly to its propellers.

|∂T/∂z| of the firmware's thrusts T by one fix z at the points of a regime, by central differences.
This is the cost of a higher gain that no decay shows. Limits of thrust, and later feedback by the
boat's motion, are left out.
"""

import flotilla
import numpy as np

from sil.certificate.loop import BODY, Boat, leader_rows
from sil.certificate.monodromy import Points
from sil.plant.hull import Array

# the noisy quantities, and their components of a fix
SOURCES = {"place": (0, 1), "heading": (2,), "velocity": (3, 4), "yaw rate": (5,)}

_DELTA = 1e-5


def noise_gains(boat: Boat, points: Points) -> dict[str, float]:
    """RMS thrust of a propeller, N, for each of `SOURCES` with independent noise of 1 m, rad, s."""
    slopes = _slopes(boat, points)
    return {
        name: float(np.sqrt(np.mean(np.sum(slopes[:, of] ** 2, axis=1))))
        for name, of in SOURCES.items()
    }


def _slopes(boat: Boat, points: Points) -> Array:
    """∂T/∂z (K, 6, 2) at the points (K)."""
    helm = flotilla.Helm(dict(boat.parameters))
    rows = leader_rows(boat.leader, boat.h_s * points.ticks.astype(np.float64)).tolist()
    nudges = _DELTA * np.vstack([np.eye(6), -np.eye(6)])
    found = np.empty((len(rows), len(nudges), 2))
    for k, (row, state) in enumerate(zip(rows, points.states, strict=True)):
        for i, fix in enumerate((state[:6] + nudges).tolist()):
            helm.state = state[BODY:].tolist()
            helm.fix(*fix, 0.0, 1.0 / boat.navigation_hz)
            thrust = helm.step(row, boat.h_s)["thrust_N"]
            found[k, i] = thrust["port"], thrust["stbd"]
    return (found[:, :6] - found[:, 6:]) / (2.0 * _DELTA)
