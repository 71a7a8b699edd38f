# SPDX-License-Identifier: MIT
"""Finds the greatest depth of a chain of boats from its gains, its noise and its turns.

`probe` measures, with small pushes, the gain G(jω) from a boat's velocity to that of its follower,
T_n(jω) from the root's velocity to that of boat n, and the corresponding slot errors; yaw and surge
separately. If every boat steers by the formation's reference (LAW_REF), all depths are sailed. If
one does not, boat n moves as boat n − 1 times G, plus its own noise:

    T_n = T_3 G^(n−3)      P_n = |G|² P_{n−1} + W      W = P_3 − |G|² P_2
    det_n(t): the lines of the leader's manoeuvre times T_n      peak_n = max |det_n| + 3.5 √(∫ P_n)

Where boats relay with losses, the figures of sailed boats are at least those of the runs with
everything at once.

P_n are the power spectra of the motion that noise and weather cause behind a leader on a straight
course. A depth is certified if no boat up to it is expected to turn faster than 0.95 LAW_R_MAX, to
be faster than LAW_U_MAX, or to be more than 0.2 m RMS off its slot: beyond these limits a chain
leaves the small motions for which gains are valid. The law itself demands no more than 0.97
LAW_R_MAX, so a boat above 0.95 is held by that limit. If the law has no such limit, the firmware's
default counts; a root that itself moves more in its manoeuvre raises the limits of yaw rate and
speed. The hop is the one from boat 2 to boat 3, which both follow boats: G = T_3 / T_2, for the
motion that a boat makes by its own thrust as it follows. With the reference, boat 2 is instead
pushed off its way for the hop: boat 3 then follows it only by the slow shift of its slot
(`core/reference.hpp`).

Every line of boats from the root is examined, except those that consist of the same kinds of boats
as another, or as its beginning.

Source of the question: Swaroop and Hedrick 1996, Seiler, Pant and Hedrick 2004.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import flotilla
import numpy as np

from sil.certificate import probe as probes
from sil.certificate.probe import (
    PUSHED_BOAT,
    SURGE,
    WINDOW_S,
    YAW,
    Complex,
    Probe,
    chain_of,
    frequencies,
    path_to,
)
from sil.certificate.references import Reference
from sil.plant.hull import Array
from sil.scenario.agents import parameters_of
from sil.scenario.scenario import Scenario

MOST_DEPTH = 20  # no deeper chain is examined, unless the scenario's is deeper
OFF_SLOT_M = 0.2
_HELD = 0.95  # ratio to LAW_R_MAX of the yaw rate from which its limit holds a boat
_SAILED = 3  # boats sailed if each follows the one before
_CREST = 3.5  # crest factor of noise: the peak of some hundred half waves
_OF_PLACE = ("MAV_SYSID", "FORM_LEADER", "FORM_OFS_N", "FORM_OFS_E")


@dataclass(frozen=True)
class Limits:
    """The limits of a chain: rad/s, m/s, m RMS."""

    yaw_rate: float
    speed: float
    off_slot_m: float

    def holds(self, depth: "Depth") -> bool:
        """Whether a boat keeps the limits."""
        return (
            depth.yaw_rate <= self.yaw_rate
            and depth.speed <= self.speed
            and depth.off_slot_m <= self.off_slot_m
        )


@dataclass(frozen=True)
class Depth:
    """The boat at a depth: its peak yaw rate and speed, rad/s, m/s, and RMS distance, m."""

    yaw_rate: float
    speed: float
    off_slot_m: float

    def worse(self, other: "Depth") -> "Depth":
        """The larger of each figure."""
        return Depth(
            max(self.yaw_rate, other.yaw_rate),
            max(self.speed, other.speed),
            max(self.off_slot_m, other.off_slot_m),
        )


@dataclass(frozen=True)
class Gains:
    """Gains over `omega` (M), rad/s: of one hop (M), and from the root to each depth (D, M)."""

    omega: list[float]
    hop: list[float]
    root: list[list[float]]


@dataclass(frozen=True)
class Chain:
    """The worst chain of a scenario behind one reference, the longest if all are certified alike.

    `path`: its boats; `reference`: whether all of them steer by the formation's reference;
    `depths`: from the first boat on; `certified`: the number of depths, from the first on, that
    keep `limits`; `examined`: all lines of boats that were examined; this one is the worst.
    """

    path: list[int]
    examined: list[list[int]]
    reference: bool
    yaw: Gains
    surge: Gains
    depths: list[Depth]
    limits: Limits

    @property
    def certified(self) -> int:
        """The depth to which every boat keeps the limits."""
        held = [self.limits.holds(depth) for depth in self.depths]
        return held.index(False) if False in held else len(held)

    @property
    def holds(self) -> bool:
        """Whether the scenario's own chain keeps the limits."""
        return self.certified >= len(self.path)


def chain(
    scenario: Scenario,
    reference: Reference,
    overrides: dict[str, float],
    *,
    path: list[int] | None = None,
    most: int = 0,
    scale: tuple[float, float] = (1.0, 1.0),
) -> Chain:
    """Sail the probes of a scenario's chains and find the greatest depth of the worst.

    `path`: the only chain to examine; `most`: number of depths, by default MOST_DEPTH or those of
    the longest chain; `scale` as in `probe.chain_of`. RunError if a chain cannot be sailed.
    """
    every = [flotilla.derived(own) for own in parameters_of(scenario, overrides)]
    paths = [path] if path else lines(scenario, every)
    depths = most or max(len(paths[0]), MOST_DEPTH)
    found = []
    for line in paths:
        along = [every[agent - 1] for agent in line]
        whole = _whole(along)
        sailed = max(_SAILED, depths) if whole else _SAILED
        parts = []
        for part in [line] if whole else _distinct(scenario, line, along):
            boats = chain_of(scenario, part, sailed, scale=scale)
            parts.append(_Sailed(probes.probe(boats, reference, overrides, part), reference, whole))
        worst = max(parts, key=lambda one: max(np.abs(axis.hop).max() for axis in one.axes))
        yaw, surge = (axis.gains(depths) for axis in worst.axes)
        limits = limits_of(along, flotilla.derived(), worst.root)
        told = worst.depths(depths)
        found.append(Chain(line, paths, whole, yaw, surge, told, limits))
    return min(found, key=lambda one: (one.holds, one.certified))


def too_deep(chain: Chain) -> str:
    """A sentence: the first boat that cannot hold, and the reason."""
    first = chain.path[chain.certified]
    at, limits = chain.depths[chain.certified], chain.limits
    why = f"{at.off_slot_m:.2g} m off its slot, over {limits.off_slot_m:.2g} m"
    if not at.speed <= limits.speed:
        why = f"{at.speed:.2g} m/s, over {limits.speed:.2g} m/s"
    if not at.yaw_rate <= limits.yaw_rate:
        why = f"{at.yaw_rate:.2g} rad/s, over {limits.yaw_rate:.2g} rad/s"
    return (
        f"a chain of {len(chain.path)} boats, certified to depth {chain.certified}: from boat "
        f"{first} on it cannot hold its slots ({why})"
    )


def limits_of(
    along: list[dict[str, float]], defaults: Mapping[str, float], root: tuple[float, float]
) -> Limits:
    """The law's limits, raised where the root's own manoeuvre, its peaks `root`, demands more."""
    yaw_rate, speed = (
        min(own[name] or defaults[name] for own in along) for name in ("LAW_R_MAX", "LAW_U_MAX")
    )
    root_yaw_rate, root_speed = root
    most = _HELD * yaw_rate
    return Limits(max(most, 1.2 * root_yaw_rate), max(speed, 1.2 * root_speed), OFF_SLOT_M)


def lines(scenario: Scenario, every: list[dict[str, float]]) -> list[list[int]]:
    """Lines of two boats or more from the root, the longest first, each sequence of kinds once."""
    kinds = [_kind(scenario, agent, own) for agent, own in enumerate(every, start=1)]
    ends = range(1, len(every) + 1)
    longest_first = sorted((path_to(scenario, end) for end in ends), key=len, reverse=True)
    kept: list[list[int]] = []
    known: set[tuple[str, ...]] = set()
    for line in longest_first:
        own = tuple(kinds[agent - 1] for agent in line)
        whole = _whole([every[agent - 1] for agent in line])
        if kept and (len(line) < 2 or (*own, str(whole)) in known):
            continue
        kept.append(line)
        for length in range(1, len(line) + 1):
            known.add((*own[:length], str(whole)))
    return kept


def _whole(along: list[dict[str, float]]) -> bool:
    """Whether all boats of a line steer by the formation's reference."""
    return all(own["LAW_REF"] > 0.0 for own in along)


def _distinct(
    scenario: Scenario, path: list[int], along: list[dict[str, float]]
) -> list[list[int]]:
    """Sections of three boats of a path, each kind once."""
    of_boats = [_kind(scenario, agent, own) for agent, own in zip(path, along, strict=True)]
    kinds: dict[tuple[str, ...], list[int]] = {}
    for begin in range(max(1, len(path) - _SAILED + 1)):
        end = begin + _SAILED
        kinds.setdefault(tuple(of_boats[begin:end]), path[begin:end])
    return list(kinds.values())


def _kind(scenario: Scenario, agent: int, own: dict[str, float]) -> str:
    """Everything on which a boat's motion in a chain depends, as text."""
    boat = scenario.boat[agent - 1]
    return repr(
        (
            tuple((k, v) for k, v in sorted(own.items()) if k not in _OF_PLACE),
            scenario.vessels()[agent],
            scenario.propeller_pairs()[agent - 1],
            scenario.boat_unit(boat),
        )
    )


class _Sailed:
    """Conclusions for all depths from the probes of one chain."""

    def __init__(self, probe: Probe, reference: Reference, whole: bool) -> None:
        self.axes = [_Axis(probe, reference, axis, whole) for axis in (YAW, SURGE)]
        boats = probe.manoeuvre[1].shape[1]
        # errors without a wave from ahead: those of noise and of the manoeuvre
        noise = [_mean_square(e) for _, e in probe.noisy]
        self._off = np.mean(noise, axis=0)
        self._manoeuvre_off = _mean_square(probe.manoeuvre[1])
        self._boats = boats
        self._lossy = [_sailed_depths(*run) for run in probe.lossy]
        # peak yaw rate and speed of the root in its manoeuvre
        root = np.abs(probe.manoeuvre[0][:, 0]).max(axis=0)
        self.root = float(root[YAW]), float(root[SURGE])

    def depths(self, count: int) -> list[Depth]:
        yaw, surge = (axis.peaks(count) for axis in self.axes)
        found = []
        for n in range(count):
            k = min(n, self._boats - 1)
            square = self._off[k] + self._manoeuvre_off[k]
            square += sum(axis.more_error(n) for axis in self.axes)
            found.append(Depth(float(yaw[n]), float(surge[n]), float(np.sqrt(square))))
        for run in self._lossy:
            found[: len(run)] = [a.worse(b) for a, b in zip(found, run, strict=False)]
        return found


def _sailed_depths(nu: Array, error: Array) -> list[Depth]:
    """Each boat's largest figures in a run with velocities (T, agents, 3), errors (T, boats, 3)."""
    yaw_rates = np.abs(nu[:, 1:, YAW]).max(axis=0)
    speeds = np.hypot(nu[:, 1:, 0], nu[:, 1:, 1]).max(axis=0)
    off_m = np.sqrt(_mean_square(error))
    return [Depth(*map(float, boat)) for boat in zip(yaw_rates, speeds, off_m, strict=True)]


class _Axis:
    """One axis of a sailed chain: hop, T_n, lines of the manoeuvre, spectra of the noise."""

    def __init__(self, probe: Probe, reference: Reference, axis: int, whole: bool) -> None:
        self._omega = frequencies(axis)
        to, error = probes.gains(probe.t_s, probe.root, axis, 0)
        self._to = to
        self._boats = len(to) - 1
        if whole:
            behind, off = probes.gains(probe.t_s, probe.boat, axis, PUSHED_BOAT)
            self.hop, self._off = behind[PUSHED_BOAT + 1], off[PUSHED_BOAT]
        else:
            self.hop, self._off = to[-1] / to[-2], error[-1] / to[-2]
        self._lines = _Lines.of(probe, reference, axis)
        self._spectra, self._grid = _spectra(probe, axis)

    def gains(self, count: int) -> Gains:
        """Magnitudes of the gains for `count` depths."""
        root = [np.abs(self._root(n)).tolist() for n in range(1, count + 1)]
        return Gains(self._omega.tolist(), np.abs(self.hop).tolist(), root)

    def _root(self, n: int) -> Complex:
        """T_n at the measured frequencies."""
        known = min(n, self._boats)
        return np.asarray(self._to[known] * self.hop ** (n - known))

    def peaks(self, count: int) -> Array:
        """Largest |velocity| (count) at each depth."""
        return np.array([self._manoeuvre(n) + _CREST * self._sigma(n) for n in range(1, count + 1)])

    def _manoeuvre(self, n: int) -> float:
        if n <= self._boats:
            return self._lines.measured[n - 1]
        gain = _between(self._lines.omega, self._omega, self.hop)
        return self._lines.peak(gain ** (n - self._boats))

    def _sigma(self, n: int) -> float:
        return float(np.sqrt(self._power(n).sum()))

    def _power(self, n: int) -> Array:
        """The power spectrum P_n."""
        if n <= self._boats:
            return np.asarray(self._spectra[n])
        gain = np.abs(_between(self._grid, self._omega, self.hop)) ** 2
        own = np.maximum(self._spectra[self._boats] - gain * self._spectra[self._boats - 1], 0.0)
        power: Array = self._spectra[self._boats]
        for _ in range(n - self._boats):
            power = np.asarray(gain * power + own)
        return power

    def more_error(self, n: int) -> float:
        """Mean square error, m², of the boat at depth n + 1 in excess of the last sailed boat's."""
        if n < self._boats:
            return 0.0
        off = np.abs(_between(self._grid, self._omega, self._off)) ** 2
        more = (off * (self._power(n) - self._power(self._boats - 1))).sum()
        at = np.abs(_between(self._lines.omega, self._omega, self._off))
        gain = np.abs(_between(self._lines.omega, self._omega, self.hop))
        lines = 0.5 * np.abs(self._lines.size) ** 2
        lines[0] = 0.0
        grown = gain ** (2 * (n - self._boats)) - gain**-2.0
        return float(max(0.0, more) + max(0.0, np.sum(at**2 * lines * grown)))


@dataclass(frozen=True)
class _Lines:
    """The last sailed boat's velocity behind the manoeuvre: Σ Re(size e^{jωt}) over a period.

    `measured`: largest |velocity| of each boat.
    """

    omega: Array
    size: Complex
    measured: list[float]

    @staticmethod
    def of(probe: Probe, reference: Reference, axis: int) -> "_Lines":
        nu = probe.manoeuvre[0][:, :, axis]
        period_s = reference.T_s if reference.kind == "periodic" and reference.T_s else WINDOW_S
        count = int(frequencies(axis)[-1] * period_s / (2.0 * np.pi)) + 1
        if reference.kind != "periodic":
            count = 1  # the manoeuvre is constant
        omega: Array = 2.0 * np.pi / period_s * np.arange(count, dtype=np.float64)
        waves = np.exp(1j * np.outer(probe.t_s, omega))
        basis = np.hstack([waves.real, -waves.imag[:, 1:]])
        found, *_ = np.linalg.lstsq(basis, nu[:, -1])
        size = found[:count].astype(np.complex128)
        size[1:] += 1j * found[count:]
        return _Lines(omega, size, np.abs(nu[:, 1:]).max(axis=0).tolist())

    def peak(self, gain: Complex) -> float:
        """Largest |velocity| over a period behind a gain at the lines."""
        period_s = 2.0 * np.pi / self.omega[1] if self.omega.size > 1 else 0.0
        waves = np.exp(1j * np.outer(np.linspace(0.0, period_s, 512), self.omega))
        return float(np.abs((waves @ (self.size * gain)).real).max())


def _spectra(probe: Probe, axis: int) -> tuple[Array, Array]:
    """Power (agents, K) of the noisy runs' velocities about their means; frequencies (K)."""
    window = np.hanning(probe.t_s.size)
    total: Array | float = 0.0
    for nu, _ in probe.noisy:
        about = nu[:, :, axis] - nu[:, :, axis].mean(axis=0)
        total = total + np.abs(np.fft.rfft(window[:, None] * about, axis=0)) ** 2
    scale = 2.0 / (len(probe.noisy) * window.size * np.sum(window**2))
    step_s = float(probe.t_s[1] - probe.t_s[0])
    grid = np.asarray(2.0 * np.pi * np.fft.rfftfreq(window.size, step_s), dtype=np.float64)
    return scale * np.asarray(total).T, grid


def _between(omega: Array, known: Array, gain: Complex) -> Complex:
    """A gain interpolated to other frequencies: 1 at zero, beyond the last one the last gain."""
    at = np.append(0.0, known)
    size = np.append(1.0, np.abs(gain))
    phase = np.append(0.0, np.unwrap(np.angle(gain)))
    return np.asarray(np.interp(omega, at, size) * np.exp(1j * np.interp(omega, at, phase)))


def _mean_square(error: Array) -> Array:
    """Mean squares (boats) of the distance from the slot, m²."""
    return np.asarray(np.mean(np.sum(error[:, :, :2] ** 2, axis=2), axis=0))
