# SPDX-License-Identifier: MIT
"""Simulates a boat in open loop over many stretches of a log: commands in, measurements out.

    u̇ = X + m22 v r + m23 r² − (d11 + d11q |u|) u + k_x |a| a_x
    m22 v̇ + m23 ṙ = −u r − (d22 + d22s |u|) v − d22q ∫ |v + x r| (v + x r) dx / L + k_y |a| a_y
    m33 ṙ + m23 v̇ = N + w − k_n a_x a_y − (m22 − 1 + k) u v − m23 u r
                    − (d33 + d33q |r| + d33s |u|) r − d22q ∫ x |v + x r| (v + x r) dx / L
    η̇ = R(ψ) ν + c

ν = [u v r] through the water, c the current, a = Rᵀ(ψ) W − [u v] the air past the boat, W the wind
over the water, w the moment of a gust; all forces and inertias divided by m11 (the names are
`hull_terms`'). X = T_port + T_stbd, N = a (T_port − T_stbd). It shares no code with the firmware's
vessel or with `sil.plant`. Source: Fossen, Handbook of Marine Craft Hydrodynamics and Motion
Control, 2nd ed., chapters 6, 7 and 10.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from flotilla import kernels

from sil.identify.hull_terms import INDEX

Array = npt.NDArray[np.float64]

STEPS = 2  # of integration for each sample
_BEFORE_S = 3.0  # of commands before a stretch, from which its first thrust comes
# As in sil/native/plant/voyage.cpp, in its order.
HULL_TERMS = (
    "m22",
    "m33",
    "m23",
    "d11",
    "d11_quadratic",
    "d22",
    "d22_quadratic",
    "d22_speed",
    "d33",
    "d33_quadratic",
    "d33_speed",
    "munk",
    "advance",
    "lag",
    "wind_x",
    "wind_y",
    "wind_n",
)


@dataclass(frozen=True)
class Body:
    """Measured with a tape: half the distance between the propellers, length; also the sample time.

    gate: width of the transition at the dead band's edge, to either side, as a share of the edge.
    """

    arm_m: float
    length_m: float
    h_s: float
    gate: float = 0.05


def simulate(terms: Array, local: Array, start: Array, commands: Array, body: Body) -> Array:
    """Measurements (samples, 6, W, C): n, e, ψ, u, v, r of W stretches for C sets of terms.

    terms (K, C); local (8, W, C): current and wind over the water, north and east, and a moment,
    then the rise of wind and moment in the second half of the stretch, the same as in the first;
    start (6, W, C): n, e, ψ of the boat and u, v, r through the water; commands (before + samples,
    W, 2), port and starboard, held for a sample; the first is `before(h)` samples before the
    stretch.
    """
    return measured(sail(terms, local, start, commands, body), terms, local, body.h_s)


def sail(terms: Array, local: Array, start: Array, commands: Array, body: Body) -> Array:
    """States (samples, 6, W, C): n, e, ψ, and u, v, r through the water; otherwise `simulate`."""
    thrust = _thrusts(terms, commands, body)
    out = np.empty((len(commands) - before(body.h_s), *start.shape))
    out[0] = start
    hull = terms[[INDEX[name] for name in HULL_TERMS]]
    kernels.sail_voyages(
        out,
        thrust,
        hull,
        local,
        before=STEPS * before(body.h_s),
        every=STEPS,
        h_s=body.h_s / STEPS,
        arm_m=body.arm_m,
        length_m=body.length_m,
    )
    return out


def before(h_s: float) -> int:
    """Samples of commands that a stretch needs before it."""
    return round(_BEFORE_S / h_s)


def static_thrust(terms: Array, commands: Array, gate: float) -> Array:
    """Steady thrust (…, C, 2) over m11 at rest under commands (…, 2); gate: as in `Body`."""
    c = commands[..., None, :]
    dead, expo = terms[INDEX["dead"]][:, None], terms[INDEX["expo"]][:, None]
    size = np.clip(np.abs(c), 0.0, 1.0)
    # No thrust below the dead band, full thrust above; the search needs a slope between them.
    works = np.clip(0.5 + (1.0 - dead / np.maximum(size, 1e-6)) / (2.0 * gate), 0.0, 1.0)
    size = works * size * (1.0 - expo + expo * size)
    side = np.array([-1.0, 1.0])
    ahead = terms[INDEX["forward"]][:, None] * (1.0 + side * terms[INDEX["gain"]][:, None])
    astern = (terms[INDEX["forward"]] * terms[INDEX["reverse"]])[:, None] * (
        1.0 + side * terms[INDEX["gain_reverse"]][:, None]
    )
    thrust: Array = np.where(c > 0.0, ahead, -astern) * size
    return thrust


def _thrusts(terms: Array, commands: Array, body: Body) -> Array:
    """Thrust demanded in each step (steps, 2, W, C), delayed by the dead time, before the lag."""
    held = np.moveaxis(static_thrust(terms, commands, body.gate), -1, 1)  # (samples, 2, W, C)
    total = np.zeros((len(held) + 1, *held.shape[1:]))
    np.cumsum(held, axis=0, out=total[1:])
    late = terms[INDEX["dead_time"]] / body.h_s
    at = np.arange(STEPS * len(commands) + 1)[:, None] / STEPS - late  # (steps + 1, C)
    at = np.clip(at, 0.0, len(held))
    whole = np.minimum(at.astype(int), len(held) - 1)
    part = at - whole
    sets = np.arange(terms.shape[1])
    low = total[whole, :, :, sets]  # (steps + 1, C, 2, W)
    high = total[whole + 1, :, :, sets]
    integral = low + part[:, :, None, None] * (high - low)
    return np.ascontiguousarray(np.moveaxis(np.diff(integral, axis=0) * STEPS, 1, -1))


def deviation(terms: Array, psi: Array) -> Array:
    """Compass deviation (…, C) at the headings psi: measured − true."""
    k = INDEX["compass"]
    off: Array = terms[k] + terms[k + 1] * np.sin(psi) + terms[k + 2] * np.cos(psi)
    return off


def measured(states: Array, terms: Array, local: Array, h_s: float) -> Array:
    """Measurements of these states (samples, 6, W, C): compass deviation, antenna, latencies."""
    _, _, psi, u, v, r = np.moveaxis(states, 1, 0)
    cos, sin = np.cos(psi), np.sin(psi)
    x, y = terms[INDEX["antenna_x"]], terms[INDEX["antenna_y"]]
    c_n, c_e = local[0], local[1]
    ahead = u + cos * c_n + sin * c_e - r * y
    side = v + cos * c_e - sin * c_n + r * x
    off = deviation(terms, psi)
    turn_cos, turn_sin = np.cos(off), np.sin(off)
    out = np.empty_like(states)
    out[:, 0] = states[:, 0] + cos * x - sin * y
    out[:, 1] = states[:, 1] + sin * x + cos * y
    out[:, 2] = psi + off
    out[:, 3] = turn_cos * ahead + turn_sin * side
    out[:, 4] = turn_cos * side - turn_sin * ahead
    out[:, 5] = r
    for rows, name in _AGES:
        slope = np.gradient(out[:, rows], h_s, axis=0)
        out[:, rows] -= terms[INDEX[name]] * slope
    return out


_AGES = (
    (slice(0, 2), "late_position"),
    (slice(3, 5), "late_velocity"),
    (slice(5, 6), "late_rate"),
)
