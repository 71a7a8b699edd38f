# SPDX-License-Identifier: MIT
"""Heading, speeds and wrench with which a boat's hull stays on its slot.

The slot's path is given, and the boat cannot choose its sway force. Therefore the heading is the
one at which the hull needs no sway force; it is found at even times along the window by Newton's
method, with differences of fourth order for ψ̇ and ψ̈. Accelerations come from the simulation's own
hull; wrenches are exact to 1e-6 of their size. Waves and gusts are left out; a steady current is
included.
"""

from dataclasses import dataclass

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from sil.certificate.motion import Motion, body_from_ground, ground_from_body, motion_of
from sil.plant import hull
from sil.plant.hull import Array, HullParameters

_PROBE_S = 1e-4
_NUDGE = 1e-6
_SMALL_N = 1e-9
_ITERATIONS, _HALVINGS = 50, 10
_MOST_RAD = 0.5  # limit of one step, about a tenth of a turn


@dataclass(frozen=True)
class SlotMotion:
    """A boat's motion on its slot and the wrench (M, 2) [X N] in N, N m at `motion.times_s`.

    `sway_N`: largest remaining sway force, which no propeller can give; 0 if the slot can be
    followed.
    """

    motion: Motion
    tau: Array
    sway_N: float


def slot_motion(
    parameters: HullParameters,
    current: Array,
    leader: Motion,
    offset_m: Array,
    turning: bool,
) -> SlotMotion:
    """Motion of a hull on its slot, in water that flows with `current` (2), m/s, north and east.

    `offset_m` (2): the slot north and east of the leader or, if it is `turning` with the leader,
    ahead and to starboard of it.
    """
    times_s = leader.times_s
    eta, rate = leader.eta(times_s), leader.eta_dot(times_s)
    place, velocity = eta[:, :2] + offset_m, rate[:, :2]
    if turning:
        arm = ground_from_body(eta[:, 2], np.broadcast_to(offset_m, (len(eta), 2)))
        place = eta[:, :2] + arm
        velocity = rate[:, :2] + rate[:, 2:] * np.stack([-arm[:, 1], arm[:, 0]], axis=-1)
    problem = _Problem(parameters, current, velocity, leader)
    psi = problem.solve(_first_heading(eta[:, 2], velocity - current))
    force, nu = problem.force(psi)
    ends = np.column_stack([place, psi])
    closed = np.vstack([ends, ends[0] + leader.drift])
    return SlotMotion(
        motion_of(leader.begin_s, leader.window_s, closed, nu),
        force[:, ::2],
        float(np.abs(force[:, 1]).max()),
    )


def _first_heading(psi: Array, through_water: Array) -> Array:
    """Headings (M) along the motion through the water; the leader's if there is hardly any."""
    ahead, abeam = body_from_ground(psi, through_water).T
    if np.hypot(ahead, abeam).max() < _NUDGE:
        return psi
    if (ahead > np.abs(abeam)).all():
        return np.asarray(psi + np.arctan2(abeam, ahead))
    # the motion may have no direction at times, so one choice holds for the whole window
    return np.asarray(psi + np.arctan2(abeam.mean(), ahead.mean()))


class _Problem:
    """The heading ψ (M) for which a hull on a given path needs no sway force."""

    def __init__(
        self, parameters: HullParameters, current: Array, velocity: Array, leader: Motion
    ) -> None:
        count = len(velocity)
        self._parameters = hull.stack([parameters] * count)
        self._current = np.broadcast_to(current, (count, 2)).copy()
        self._velocity = velocity
        self._slope = leader.drift[2] / leader.window_s
        self._drift = self._slope * (leader.times_s - leader.begin_s)
        self._first = _difference(count, leader.window_s)
        self._second = self._first @ self._first
        self._acceleration = self._first @ velocity
        still = np.zeros((count, 3))
        drifting = self._rates(still, still[:, 0], np.zeros(3))[0]
        unit = [self._rates(still, still[:, 0], w)[0] - drifting for w in np.eye(3)]
        self._inertia = np.linalg.inv(np.array(unit).T)

    def solve(self, psi: Array) -> Array:
        wave = psi - self._drift
        for _ in range(_ITERATIONS):
            rate, jerk = self._turning(wave)
            here = self._needed(wave, rate, jerk)[:, 1]
            if np.abs(here).max() < _SMALL_N:
                break
            by_psi, by_rate, by_jerk = (
                (self._needed(*near)[:, 1] - here) / _NUDGE
                for near in (
                    (wave + _NUDGE, rate, jerk),
                    (wave, rate + _NUDGE, jerk),
                    (wave, rate, jerk + _NUDGE),
                )
            )
            slope = (
                sparse.diags_array(by_psi)
                + sparse.diags_array(by_rate) @ self._first
                + sparse.diags_array(by_jerk) @ self._second
            )
            step = np.atleast_1d(spsolve(sparse.csc_array(slope), -here))
            step *= min(1.0, _MOST_RAD / max(np.abs(step).max(), 1e-12))
            for _ in range(_HALVINGS):
                if np.linalg.norm(self._sway(wave + step)) < np.linalg.norm(here):
                    break
                step /= 2.0
            wave = wave + step
        return np.asarray(wave + self._drift)

    def _turning(self, wave: Array) -> tuple[Array, Array]:
        return np.asarray(self._first @ wave) + self._slope, np.asarray(self._second @ wave)

    def _sway(self, wave: Array) -> Array:
        force: Array = self._needed(wave, *self._turning(wave))
        return force[:, 1]

    def force(self, psi: Array) -> tuple[Array, Array]:
        """Forces [X Y N] (M, 3) that the path needs at these headings; velocities ν (M, 3)."""
        wave = psi - self._drift
        rate, jerk = self._turning(wave)
        nu = np.column_stack([body_from_ground(psi, self._velocity), rate])
        return self._needed(wave, rate, jerk), nu

    def _needed(self, wave: Array, rate: Array, jerk: Array) -> Array:
        psi = wave + self._drift
        u, v = body_from_ground(psi, self._velocity).T
        a_u, a_v = body_from_ground(psi, self._acceleration).T
        wanted = np.column_stack([a_u + rate * v, a_v - rate * u, jerk])
        free = self._rates(np.column_stack([u, v, rate]), psi, np.zeros(3))
        return np.asarray((wanted - free) @ self._inertia.T)

    def _rates(self, nu: Array, psi: Array, force: Array) -> Array:
        """Accelerations (M, 3) of the hulls under one body-fixed force."""
        ends = []
        no_wrench, pushed = np.zeros((3, len(nu), 2)), np.tile(force, (len(nu), 1))
        for h_s in (_PROBE_S, -_PROBE_S):
            eta, end = np.column_stack([np.zeros((len(nu), 2)), psi]), nu.copy()
            water = (pushed, self._current, self._parameters)
            hull.advance(eta, end, no_wrench, *water, h_s)
            ends.append(end)
        return (ends[0] - ends[1]) / (2.0 * _PROBE_S)


def _difference(count: int, window_s: float) -> sparse.csr_array:
    """Periodic fourth-order differences of `count` even samples; zero for a constant motion."""
    if count == 1:
        return sparse.csr_array((1, 1))
    h_s = window_s / count
    weights = {-2: 1.0 / 12.0, -1: -2.0 / 3.0, 1: 2.0 / 3.0, 2: -1.0 / 12.0}
    rows = np.arange(count)
    total = sparse.csr_array((count, count))
    for shift, weight in weights.items():
        entries = (np.full(count, weight / h_s), (rows, (rows + shift) % count))
        total = total + sparse.csr_array(entries, shape=(count, count))
    return total
