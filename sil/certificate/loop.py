# SPDX-License-Identifier: MIT
"""The sampled closed loop of one boat, in several copies: the firmware's law on the simulated hull.

At each tick the navigation unit, if it is due, gives the firmware the true state. The firmware's
own estimator and law (`flotilla.Helm`, double precision, without bytes) answer with two thrusts,
which hold until the next tick and pass through the propellers' curve and lag. The leader moves
along a given path, and the boat receives its motion without delay. Left out: the navigation unit's
delay (navigation.delay_s), rounding on the wires, THR_DEAD, THR_SLEW, noise and waves.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property

import flotilla
import numpy as np

from sil.certificate.motion import Motion
from sil.plant import hull, propeller
from sil.plant.hull import Array, HullParameters
from sil.plant.propeller import PropellerParameters

# leading components of the state: pose, velocity, thrusts; the firmware's memory follows
BODY = 8
# the state's components in order: the body's, then the memory of `flotilla.Helm`
COMPONENTS = (
    *("x", "y", "psi", "u", "v", "r", "thrust port", "thrust stbd"),
    *("x known", "y known", "psi known", "u known", "v known", "r known"),
    *("unknown surge", "unknown sway", "unknown yaw", "current north", "current east"),
    *("v*", "u* held", "r* held"),
    *("slot sway", "slot speed", "slot speed rate", "slip", "slip rate", "approach"),
    *("given X", "given N"),
)


@dataclass(frozen=True)
class Boat:
    """Everything on which a boat's loop depends; `parameters`: the firmware's.

    `current` (2): m/s, north and east; `slot`: the boat's own motion on its slot; `rate_hz`: rate
    of the ticks.
    """

    hull: HullParameters
    propellers: PropellerParameters
    parameters: Mapping[str, float]
    current: tuple[float, float]
    navigation_hz: float
    rate_hz: float
    leader: Motion
    slot: Motion

    @property
    def h_s(self) -> float:
        """Time between two ticks, s."""
        return 1.0 / self.rate_hz

    @property
    def cycle(self) -> int:
        """Number of ticks after which the pattern of fixes repeats."""
        return Fraction(self.rate_hz / self.navigation_hz).limit_denominator(100).numerator

    @cached_property
    def _fixes_per_tick(self) -> Fraction:
        return Fraction(self.navigation_hz / self.rate_hz).limit_denominator(100)

    def fix_due(self, tick: int) -> bool:
        """Whether a fix arrives at a tick."""
        fixes, ticks = self._fixes_per_tick.as_integer_ratio()
        return tick * fixes // ticks != (tick - 1) * fixes // ticks

    def with_parameters(self, changed: Mapping[str, float]) -> "Boat":
        """The same boat with changed firmware parameters."""
        return replace(self, parameters={**self.parameters, **changed})


class Loop:
    """Copies of a boat, started on its slot at a tick; `state` (copies, n) is their whole state.

    A row: [x y ψ], [u v r], thrusts port and starboard, then `flotilla.Helm`'s state: `COMPONENTS`.
    """

    def __init__(self, boat: Boat, copies: int) -> None:
        self.boat = boat
        self.tick = 0
        self.limited = False
        self._parameters = dict(boat.parameters)
        self._helms = flotilla.Helms(self._parameters, copies)
        self._hulls = np.tile(hull.stack([boat.hull]), (copies, 1))
        self._pairs = np.tile(propeller.stack([boat.propellers]), (copies, 1))
        self._current = np.tile(boat.current, (copies, 1))
        self._no_force = np.zeros((copies, 3))
        self._tau = np.zeros((3, copies, 2))
        self._asked = np.zeros((copies, 2))
        self.eta = np.zeros((copies, 3))
        self.nu = np.zeros((copies, 3))
        self.thrust = np.zeros((copies, 2))
        self._curve = _Curve.of(boat.parameters)
        self._fresh = True

    def start(self, tick: int) -> None:
        """Put all copies on the slot, as if the firmware had just entered FORMATION."""
        self.tick = tick
        time_s = np.array([tick * self.boat.h_s])
        self.eta[:], self.nu[:] = self.boat.slot.eta(time_s), self.boat.slot.nu(time_s)
        self._helms = flotilla.Helms(self._parameters, len(self.eta))
        self._fresh = True

    @property
    def state(self) -> Array:
        """The current state, before the tick."""
        remembered = np.empty((len(self.eta), len(COMPONENTS) - BODY))
        self._helms.state(remembered)
        return np.hstack([self.eta, self.nu, self.thrust, remembered])

    def resume(self, tick: int, state: Array) -> None:
        """Continue from `state` (copies, n) at a tick."""
        self.tick = tick
        self.eta[:], self.nu[:], self.thrust[:] = state[:, :3], state[:, 3:6], state[:, 6:BODY]
        self._helms.set_state(np.ascontiguousarray(state[:, BODY:]))
        self._fresh = False

    def step(self, leader: Array) -> None:
        """Advance by one tick; `leader` (9): its current pose, velocity and their rates."""
        boat = self.boat
        if self._fresh or boat.fix_due(self.tick):
            self._helms.fix(self.eta, self.nu, 0.0, 0.0 if self._fresh else 1 / boat.navigation_hz)
        missing = self._helms.step(leader.tolist(), boat.h_s, self._asked)
        self.limited = self.limited or missing > 1e-9
        command = self._curve(self._asked)
        propeller.advance(self.thrust, command, self._tau, self._pairs, boat.h_s)
        water = (self._no_force, self._current, self._hulls)
        hull.advance(self.eta, self.nu, self._tau, *water, boat.h_s)
        self._fresh = False
        self.tick += 1


def leader_rows(leader: Motion, times_s: Array) -> Array:
    """The leader's motion at times (T), as a boat receives it: pose, velocity, its rates (T, 9)."""
    return np.hstack([leader.eta(times_s), leader.nu(times_s), leader.nu_dot(times_s)])


@dataclass(frozen=True)
class _Curve:
    """The firmware's command for a thrust: the inverse of its THR_* curve."""

    forward_N: Array  # (2): port, starboard
    reverse_N: Array
    expo: float

    @staticmethod
    def of(parameters: Mapping[str, float]) -> "_Curve":
        balance = parameters["THR_BALANCE"]
        sides = np.array([1.0 - balance, 1.0 + balance])
        forward_N, reverse_N = (sides * parameters[f"THR_{way}_MAX"] for way in ("FWD", "REV"))
        return _Curve(forward_N, reverse_N, parameters["THR_EXPO"])

    def __call__(self, thrust_N: Array) -> Array:
        share = np.abs(thrust_N) / np.where(thrust_N >= 0.0, self.forward_N, self.reverse_N)
        linear = 1.0 - self.expo
        if self.expo > 0.0:
            root = np.sqrt(linear * linear + 4.0 * self.expo * share)
            share = 2.0 * share / np.where(share > 0.0, linear + root, 1.0)
        return np.asarray(np.copysign(share, thrust_N))
