# SPDX-License-Identifier: MIT
"""Periodic motions with a drift, as Fourier series: exact between their samples.

η = [x y ψ] north-east-down, ψ not wrapped (m, rad); ν = [u v r] over ground in body axes.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from sil.plant.hull import Array

Spectrum = npt.NDArray[np.complex128]

_NOISE = 1e-13  # smaller harmonics, relative to the largest sample, are rounding errors


@dataclass(frozen=True)
class Series:
    """k functions of period `window_s`, from their values (M, k) at M even times from `begin_s` on.

    Between samples, they are the trigonometric polynomials through the samples.
    """

    begin_s: float
    window_s: float
    values: Array

    def at(self, t_s: Array) -> Array:
        """Values (T, k) at the times (T), s."""
        return self._sum(t_s, 0)

    def rate(self, t_s: Array) -> Array:
        """Derivatives (T, k) at the times (T), in 1/s."""
        return self._sum(t_s, 1)

    def _sum(self, t_s: Array, order: int) -> Array:
        spectrum = self._spectrum
        omega = 2.0 * np.pi * np.arange(1, len(spectrum)) / self.window_s
        turning = np.exp(1j * np.outer(t_s - self.begin_s, omega)) * (1j * omega) ** order
        mean = spectrum[:1].real if order == 0 else np.zeros((1, self.values.shape[1]))
        return np.asarray(mean + 2.0 * (turning @ spectrum[1:]).real)

    @cached_property
    def _spectrum(self) -> Spectrum:
        """The mean and the harmonics (H, k) above rounding errors."""
        spectrum = np.fft.rfft(self.values, axis=0) / len(self.values)
        large = np.abs(spectrum).max(axis=1) > _NOISE * np.abs(self.values).max(initial=1e-300)
        top = int(np.flatnonzero(large)[-1]) if large.any() else 0
        # the half-sample harmonic of an even number of samples has no derivative
        return np.asarray(spectrum[: min(top, (len(self.values) - 1) // 2) + 1])


@dataclass(frozen=True)
class Motion:
    """A vessel's motion over a window, after which it repeats itself, shifted by `drift`.

    `nu`, and `eta` less the drift so far, are periodic; `drift` (3): [m, m, rad] per window.
    """

    eta_periodic: Series
    nu_periodic: Series
    drift: Array

    @property
    def window_s(self) -> float:
        """Length of the window, s."""
        return self.nu_periodic.window_s

    @property
    def begin_s(self) -> float:
        """Time of the first sample, s."""
        return self.nu_periodic.begin_s

    @property
    def times_s(self) -> Array:
        """The times (M) of the samples."""
        count = len(self.nu_periodic.values)
        return self.begin_s + self.window_s * np.arange(count) / count

    def eta(self, t_s: Array) -> Array:
        """Poses (T, 3) at the times (T)."""
        windows = (t_s - self.begin_s)[:, None] / self.window_s
        return self.eta_periodic.at(t_s) + windows * self.drift

    def eta_dot(self, t_s: Array) -> Array:
        """Rates of the poses (T, 3): velocity north, east, yaw rate."""
        return self.eta_periodic.rate(t_s) + self.drift / self.window_s

    def nu(self, t_s: Array) -> Array:
        """Velocities over ground in body axes (T, 3)."""
        return self.nu_periodic.at(t_s)

    def nu_dot(self, t_s: Array) -> Array:
        """Rates of the three components of `nu` (T, 3)."""
        return self.nu_periodic.rate(t_s)


def motion_of(begin_s: float, window_s: float, eta: Array, nu: Array) -> Motion:
    """Motion through poses (M + 1, 3) and velocities (M, 3): M even steps and the window's end."""
    drift = eta[-1] - eta[0]
    share = (np.arange(len(nu)) / len(nu))[:, None]
    periodic = eta[:-1] - share * drift
    return Motion(Series(begin_s, window_s, periodic), Series(begin_s, window_s, nu), drift)


def body_from_ground(psi: Array, velocity: Array) -> Array:
    """[u v] (..., 2) of velocities [north east] (..., 2) at the headings (...)."""
    cos, sin = np.cos(psi), np.sin(psi)
    north, east = velocity[..., 0], velocity[..., 1]
    return np.stack([cos * north + sin * east, cos * east - sin * north], axis=-1)


def ground_from_body(psi: Array, velocity: Array) -> Array:
    """[north east] (..., 2) of vectors [forward starboard] (..., 2) at the headings (...)."""
    return body_from_ground(-np.asarray(psi), velocity)
