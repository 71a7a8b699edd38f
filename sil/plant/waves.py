# SPDX-License-Identifier: MIT
"""Long-crested waves on deep water: a sum of sinusoids, and its forces on a boat.

ζ = Σ a_i cos φ_i,  φ_i = ω_i t − k_i s + ε_i,  k_i = ω_i²/g,  s: distance along the course.

First order: the water's orbital acceleration −ω_i² a_i e^{−k_i T/2} sin φ_i along the course,
averaged over two slender hulls of length L at ±b from the centreline, times the boat's inertia
with added mass: the Froude-Krylov and the diffraction force of a body that is small beside the
waves. Second order: ½ ρ g W |Σ a_i e^{jφ_i}|² along the course, which is Maruo's drift force with
a constant reflection in Newman's approximation: differences of frequencies only.
Sources: Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd ed., section 10.2;
Faltinsen, Sea Loads on Ships and Offshore Structures, chapters 3 and 5.
"""

from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np
from flotilla import kernels

from sil.plant.hull import Array

GRAVITY_MPS2 = 9.81
WATER_KGPM3 = 1025.0

# Share of the peak frequency; outside this range is less than 1 % of the energy, and no force on a
# boat.
_BAND = (0.5, 4.0)


@dataclass(frozen=True)
class WaveBody:
    """A boat's properties in waves: inertia, wetted hulls, widths W that reflect waves."""

    m11: float
    m22: float
    length_m: float
    draft_m: float
    hull_y_m: float  # b: from the centreline to each of the two hulls, 0 for one hull
    drift_x_m: float
    drift_y_m: float


def jonswap(omega: Array, height_m: float, period_s: float, peakedness: float) -> Array:
    """JONSWAP spectrum S(ω) (...), m² s; with peakedness 1, the Pierson-Moskowitz spectrum.

    With peakedness 1 the significant height is `height_m`; a higher peak has more energy.
    """
    peak = 2.0 * np.pi / period_s
    ratio = peak / omega
    width = np.where(omega <= peak, 0.07, 0.09)
    enhanced = np.exp(-0.5 * ((omega / peak - 1.0) / width) ** 2)
    moskowitz = 0.3125 * height_m**2 * ratio**4 / omega * np.exp(-1.25 * ratio**4)
    return np.asarray(moskowitz * peakedness**enhanced)


class Sea:
    """Waves of `components` sinusoids whose phases `rng` draws.

    `height_m` is the significant height: the variance of ζ is height²/16 exactly. `period_s`:
    period of the peak; `course_rad`: direction to which the waves travel, clockwise from north.
    `waves` (components, 4): ω, k, a, ε of each.
    """

    def __init__(
        self,
        *,
        height_m: float,
        period_s: float,
        course_rad: float,
        peakedness: float,
        components: int,
        rng: np.random.Generator,
    ) -> None:
        peak = 2.0 * np.pi / period_s
        edges = peak * np.geomspace(*_BAND, components + 1)
        width = np.diff(edges)
        # At random in its band: with equal steps the waves would repeat themselves.
        omega = edges[:-1] + width * rng.random(components)
        energy = jonswap(omega, height_m, period_s, peakedness) * width
        amplitude = np.sqrt(energy / energy.sum() * height_m**2 / 8.0)
        phase = rng.uniform(0.0, 2.0 * np.pi, components)
        self.waves: Array = np.stack([omega, omega**2 / GRAVITY_MPS2, amplitude, phase], axis=-1)
        self.course_rad = course_rad

    def elevation_m(self, t_s: float, x_m: float, y_m: float) -> float:
        """Height, m, of the surface over still water at a time and place (north, east)."""
        omega, k, amplitude, phase = self.waves.T
        way = x_m * np.cos(self.course_rad) + y_m * np.sin(self.course_rad)
        return float(np.sum(amplitude * np.cos(omega * t_s - k * way + phase)))


class Waves:
    """The waves' force on N boats of each of R runs.

    `seas` (R): None for a calm sea; `bodies` (R, N).
    """

    def __init__(self, seas: Sequence[Sea | None], bodies: Sequence[Sequence[WaveBody]]) -> None:
        self._counts = np.array([len(sea.waves) if sea else 0 for sea in seas])
        self._waves = np.zeros((len(seas), self._counts.max(), 4))
        self._course_rad = np.zeros(len(seas))
        for run, sea in enumerate(seas):
            if sea is not None:
                self._waves[run, : len(sea.waves)] = sea.waves
                self._course_rad[run] = sea.course_rad
        self._bodies = np.array([[astuple(body) for body in run] for run in bodies])

    def push(self, t_s: float, eta: Array, _nu: Array, _h_s: float, w: Array, /) -> None:
        """Add the force on boats at eta at `t_s` to w; both (R, N, 3)."""
        sea = self._waves, self._counts, self._course_rad
        kernels.add_waves(t_s, eta, *sea, self._bodies, w, 0.5 * WATER_KGPM3 * GRAVITY_MPS2)
