# SPDX-License-Identifier: MIT
"""Logs of hulls of the simulation's own physics, which shares no code with the identification."""

from dataclasses import dataclass

import numpy as np

from sil.identify.voyage_log import SAMPLE_S, Array, Channel, VoyageLog, sampled
from sil.plant import hull, propeller
from sil.plant.hull import HullParameters
from sil.plant.propeller import PropellerParameters

STEP_S = 0.02

# Directionally stable up to some 1.8 m/s: what it sails can be predicted.
HULL = HullParameters(
    m11=18.0,
    m22=22.0,
    m33=3.2,
    d11=3.0,
    d22=30.0,
    d33=8.0,
    d11_quadratic=7.0,
    d33_quadratic=2.0,
)
PROPELLERS = PropellerParameters(
    arm_m=0.28,
    forward_max_N=35.0,
    reverse_max_N=20.0,
    expo=0.4,
    lag_s=0.15,
    port_gain=0.95,
    stbd_gain=1.05,
)


@dataclass(frozen=True)
class Noise:
    """Standard deviations: m, rad, m/s, rad/s."""

    position: float = 0.02
    heading: float = 0.005
    velocity: float = 0.02
    rate: float = 0.005


def levels(rng: np.random.Generator, duration_s: float) -> Array:
    """Commands (samples, 2): both, one, or a pair apart, each held for 1 to 6 s, with coasting."""
    rows: list[Array] = []
    while len(rows) < duration_s / SAMPLE_S:
        both, apart = rng.uniform(-0.7, 1.0), rng.uniform(-0.6, 0.6)
        kind = rng.integers(5)
        pair = np.array(
            [
                (both, both),
                (both - 0.5 * apart, both + 0.5 * apart),
                (apart, -apart),
                (both, 0.0),
                (0.0, 0.0),
            ][kind]
        )
        rows += [np.clip(pair, -1.0, 1.0)] * round(rng.uniform(1.0, 6.0) / SAMPLE_S)
    return np.array(rows)[: round(duration_s / SAMPLE_S)]


def sail(
    commands: Array,
    rng: np.random.Generator,
    noise: Noise = Noise(),
    vessel: HullParameters = HULL,
    pair: PropellerParameters = PROPELLERS,
    current: tuple[float, float] = (0.0, 0.0),
) -> VoyageLog:
    """The log (10 Hz) of a boat that was given these commands."""
    hulls, pairs = hull.stack([vessel]), propeller.stack([pair])
    eta, nu, thrust = np.zeros((1, 3)), np.zeros((1, 3)), np.zeros((1, 2))
    tau, w, water = np.zeros((3, 1, 2)), np.zeros((1, 3)), np.array([current])
    motion = np.empty((len(commands), 6))
    for k, command in enumerate(commands):
        motion[k] = *eta[0], *nu[0]
        for _ in range(round(SAMPLE_S / STEP_S)):
            propeller.advance(thrust, command[None, :].copy(), tau, pairs, STEP_S)
            hull.advance(eta, nu, tau, w, water, hulls, STEP_S)
    deviations = [noise.position] * 2 + [noise.heading] + [noise.velocity] * 2 + [noise.rate]
    motion += rng.normal(0.0, 1.0, motion.shape) * deviations
    t: Array = np.arange(len(commands), dtype=np.float64) * SAMPLE_S
    parts = [Channel(t, motion[:, columns]) for columns in ([0, 1], [2], [3, 4], [5])]
    return sampled("sailed", parts, Channel(t, commands))
