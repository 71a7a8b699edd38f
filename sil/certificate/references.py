# SPDX-License-Identifier: MIT
"""The reference: the virtual leader's hull under each of its inputs, brought to a steady regime.

An input is constant, or constant plus a sine in yaw, so the steady velocity is constant or has the
sine's period; it is integrated by the simulation's own hull, in steps of 2 ms, until it repeats
itself to 1e-11. Source of T, μ and ω̄_d: Wang and Loría, eq:PE, eq:bound.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.optimize import root

from sil.certificate.motion import Motion, motion_of
from sil.plant import hull
from sil.plant.hull import Array, HullParameters
from sil.scenario.scenario import Scenario
from sil.scenario.sections import Input, Leader

Kind = Literal["periodic", "turning", "straight", "rest"]

_STEP_S = 0.002
_REPEATS = 1e-11
_PATIENCE_S = 3000.0
_STILL = 1e-9
_HELD = 1e-6  # change of velocity of a hull that is held, m/s² and rad/s²
_SAMPLES = 256  # samples of a period, and of a circle
_WINDOW_S = 1.0  # window of a straight leg, all of whose seconds are alike
_PERIODS = 30  # greatest number of periods in a window, until the heading has returned


@dataclass(frozen=True)
class Reference:
    """Agent 0 under one of its inputs.

    `motion`: its steady regime. `T_s`, `mu`: T and μ of eq:PE. T is a period of the input, or a
    step of 2 ms in a constant turn, where any T is valid; None and 0 without excitation.
    `omega_max`, `omega_dot_max`: largest |ω_d|, |ω̇_d|, rad/s and rad/s².
    """

    input: Input
    kind: Kind
    motion: Motion
    T_s: float | None
    mu: float
    omega_max: float
    omega_dot_max: float

    @property
    def from_s(self) -> float:
        """Time after the release at which the reference begins, s."""
        return self.input.from_s

    @property
    def omega_bar(self) -> float:
        """ω̄_d, the bound on |ω_d| and |ω̇_d|."""
        return max(self.omega_max, self.omega_dot_max)


def references(scenario: Scenario) -> list[Reference]:
    """A reference for every input of the virtual leader that lies within the scenario.

    ValueError if a steady regime is not reached.
    """
    agent = _Agent(scenario)
    found = []
    for segment, until_s in _segments(scenario):
        agent.sail(segment, until_s)
        found.append(_steady(agent.copy(), segment))
    return found


def _segments(scenario: Scenario) -> Iterator[tuple[Input, float]]:
    """The inputs, with the idle one before the first, each with its end, s."""
    inputs = _inputs_of_route(scenario) or list(scenario.leader.input)
    if not inputs or inputs[0].from_s > 0.0:
        inputs.insert(0, Input())
    ends = [*(later.from_s for later in inputs[1:]), math.inf]
    for segment, end_s in zip(inputs, ends, strict=True):
        if segment.from_s < scenario.duration_s:
            yield segment, min(end_s, scenario.duration_s)


def _inputs_of_route(scenario: Scenario) -> list[Input]:
    """Inputs with which the leader's hull sails like its route: straight, and its sharpest turns.

    Each begins when the route first does so; there are none without waypoints. Under a constant
    wrench a hull that is unstable in yaw, as the Heron, turns more sharply than its route does: its
    certificate is of that turn.
    """
    if not scenario.leader.waypoints:
        return []
    motion = scenario.route()
    sailed = motion[: scenario.ticks]
    own = scenario.hulls()[0]
    steady = {0: sailed[:, 3].argmax(), 1: sailed[:, 5].argmax(), 2: sailed[:, 5].argmin()}
    inputs = []
    for tick in sorted(set(steady.values())):
        surge_N, yaw_Nm = _holding(own, sailed[tick, 3], sailed[tick, 5])
        from_s = tick * scenario.step_s
        inputs.append(Input(from_s=from_s, surge_N=surge_N, yaw_Nm=yaw_Nm))
    return inputs


def _holding(own: HullParameters, u: float, r: float) -> tuple[float, float]:
    """Surge force and yaw moment with which the simulation's hull keeps surge u and yaw rate r.

    ValueError if there are none: without sway drag a hull in a turn drifts on.
    """
    stack = hull.stack([own])

    def change(wanted: Array) -> Array:
        surge_N, yaw_Nm, v = wanted
        tau = np.broadcast_to((surge_N, yaw_Nm), (3, 1, 2)).copy()
        eta, nu = np.zeros((1, 3)), np.array([[u, v, r]])
        hull.advance(eta, nu, tau, np.zeros((1, 3)), np.zeros((1, 2)), stack, _STEP_S)
        return np.asarray((nu[0] - (u, v, r)) / _STEP_S)

    found = root(change, (own.d11 * u, own.d33 * r, 0.0), tol=1e-12)
    if np.abs(found.fun).max() > _HELD:
        raise ValueError(f"no thrust holds the leader's hull at {u:.2f} m/s and {r:.3f} rad/s")
    return float(found.x[0]), float(found.x[1])


class _Agent:
    """The virtual leader's hull, and its time."""

    def __init__(self, scenario: Scenario) -> None:
        self.t_s = 0.0
        self.eta: Array = np.array([scenario.leader.eta])
        self.nu: Array = np.array([scenario.leader.nu])
        self._scenario = scenario
        self._parameters = hull.stack(scenario.hulls()[:1])

    def copy(self) -> "_Agent":
        twin = _Agent(self._scenario)
        twin.t_s, twin.eta, twin.nu = self.t_s, self.eta.copy(), self.nu.copy()
        return twin

    def sail(self, segment: Input, until_s: float, steps: int | None = None) -> None:
        """Advance the hull to `until_s` under one input, in steps of at most 2 ms."""
        count = steps or max(1, math.ceil((until_s - self.t_s) / _STEP_S))
        h_s = (until_s - self.t_s) / count
        leader = Leader(input=(segment.model_copy(update={"from_s": 0.0}),))
        times_s: Array = self.t_s + 0.5 * h_s * np.arange(2 * count + 1, dtype=np.float64)
        tau = leader.tau(times_s)[:, None]
        no_force, no_current = np.zeros((1, 3)), np.zeros((1, 2))
        hull.sail(self.eta, self.nu, tau, no_force, no_current, self._parameters, h_s)
        self.t_s = until_s


def _steady(agent: _Agent, segment: Input) -> Reference:
    sine = segment.yaw_sine_Nm != 0.0 and segment.yaw_sine_rad_s != 0.0
    period_s = 2.0 * math.pi / abs(segment.yaw_sine_rad_s) if sine else _WINDOW_S
    end_s = agent.t_s + _PATIENCE_S
    before = np.full(3, np.inf)
    turned = 0.0
    while np.abs(agent.nu[0] - before).max() > _REPEATS:
        if agent.t_s > end_s or not np.isfinite(agent.nu).all():
            raise ValueError(
                f"the leader's input from {segment.from_s:g} s on has no steady regime"
            )
        before, psi = agent.nu[0].copy(), agent.eta[0, 2]
        agent.sail(segment, agent.t_s + period_s)
        turned = agent.eta[0, 2] - psi
    if sine:
        window_s = period_s * _closing(turned)
        motion = _recorded(agent, segment, window_s, _SAMPLES * round(window_s / period_s))
        return _reference(segment, "periodic", motion, period_s)
    kind, window_s = _constant(agent.nu[0])
    motion = _recorded(agent, segment, window_s, _SAMPLES if kind == "turning" else 1)
    # all windows excite equally; the shortest gives the formulas their best values
    return _reference(segment, kind, motion, _STEP_S if kind == "turning" else None)


def _constant(nu: Array) -> tuple[Kind, float]:
    u, v, r = nu
    if abs(r) > _STILL:
        return "turning", 2.0 * math.pi / abs(r)
    return ("straight" if math.hypot(u, v) > _STILL else "rest"), _WINDOW_S


def _closing(turned: float) -> int:
    """Number of periods, each a turn by `turned`, after which the heading is nearest its start."""
    periods = np.arange(1, _PERIODS + 1)
    gap = np.abs(np.angle(np.exp(1j * turned * periods)))
    return int(periods[np.argmax(gap < gap.min() + 1e-6)])


def _recorded(agent: _Agent, segment: Input, window_s: float, samples: int) -> Motion:
    begin_s, step_s = agent.t_s, window_s / samples
    eta, nu = [agent.eta[0].copy()], [agent.nu[0].copy()]
    for k in range(1, samples + 1):
        agent.sail(segment, begin_s + k * step_s)
        eta.append(agent.eta[0].copy())
        nu.append(agent.nu[0].copy())
    velocities = np.array(nu[:-1])
    if samples == 1:
        velocities[np.abs(velocities) < _STILL] = 0.0
    return motion_of(begin_s, window_s, np.array(eta), velocities)


def _reference(segment: Input, kind: Kind, motion: Motion, T_s: float | None) -> Reference:
    fine = np.linspace(motion.begin_s, motion.begin_s + motion.window_s, 32 * _SAMPLES)
    omega = motion.nu(fine)[:, 2]
    # over whole periods, the mean of ω² is that of its samples, to rounding
    mean_square = float(np.mean(np.square(motion.nu_periodic.values[:, 2])))
    return Reference(
        input=segment,
        kind=kind,
        motion=motion,
        T_s=T_s,
        mu=0.0 if T_s is None else T_s * mean_square,
        omega_max=float(np.abs(omega).max()),
        omega_dot_max=float(np.abs(motion.nu_dot(fine)[:, 2]).max()),
    )
