# SPDX-License-Identifier: MIT
"""The figures that an owner and the firmware want of a hull: newtons, kilograms, parameters."""

from dataclasses import dataclass

import numpy as np

from sil.identify.hull_terms import INDEX
from sil.identify.identification import Identification
from sil.identify.voyage_log import Array

SPEEDS_MPS = (0.5, 1.0)
RATES_RADPS = (0.1, 0.3)
_DAMPED_RADPS = 0.2  # where the quadratic yaw damping is taken as linear


@dataclass(frozen=True)
class Boat:
    """Measured with scales and a tape. surge_mass_kg: VES_M11, the mass with the water's share."""

    mass_kg: float
    added: float = 0.05

    @property
    def surge_mass_kg(self) -> float:
        """Inertia in surge: a log determines all else relative to it."""
        return self.mass_kg * (1.0 + self.added)


def drag_N(terms: Array, m11_kg: float, speed_mps: float) -> Array:
    """Drag ahead at a speed of terms (…, K)."""
    linear, quadratic = terms[..., INDEX["d11"]], terms[..., INDEX["d11_quadratic"]]
    drag: Array = m11_kg * (linear + quadratic * speed_mps) * speed_mps
    return drag


def yaw_moment_Nm(terms: Array, m11_kg: float, rate_radps: float, length_m: float) -> Array:
    """Moment that holds a yaw rate at rest, the cross-flow's included."""
    crossflow = terms[..., INDEX["d22_quadratic"]] * length_m**3 / 32.0  # ∫ |x|³ dx / L
    linear, quadratic = terms[..., INDEX["d33"]], terms[..., INDEX["d33_quadratic"]]
    moment: Array = m11_kg * (linear + (quadratic + crossflow) * rate_radps) * rate_radps
    return moment


def working_speed_mps(found: Identification) -> float:
    """Median speed ahead while the propellers work: where drag is taken as linear."""
    u = np.concatenate([log.motion[:, 3] for log in found.logs])
    busy = np.concatenate([np.abs(log.commands).max(axis=1) > 0.05 for log in found.logs])
    ahead = u[busy & (u > 0.1)]
    return float(np.median(ahead)) if len(ahead) else 0.5


def parameters(found: Identification, boat: Boat) -> dict[str, float]:
    """The firmware's parameters of this hull, drag as linear at the working speed."""
    terms, body, m11 = found.fit.values, found.problem.body, boat.surge_mass_kg
    t = {name: float(terms[k]) for name, k in INDEX.items()}
    speed = working_speed_mps(found)
    yaw = yaw_moment_Nm(terms, m11, _DAMPED_RADPS, body.length_m) / _DAMPED_RADPS
    out = {
        "VES_M11": m11,
        "VES_M22": m11 * t["m22"],
        "VES_M33": m11 * t["m33"],
        "VES_D11": m11 * (t["d11"] + t["d11_quadratic"] * speed),
        "VES_D22": m11 * (t["d22"] + t["d22_speed"] * speed),
        "VES_D33": float(yaw),
        "THR_ARM": body.arm_m,
        "THR_FWD_MAX": m11 * t["forward"],
        "THR_REV_MAX": m11 * t["forward"] * t["reverse"],
        "THR_EXPO": t["expo"],
        "BOAT_LEN": body.length_m,
    }
    if found.wiring.port_inverted:
        out["THR_PORT_DIR"] = -1.0
    if found.wiring.stbd_inverted:
        out["THR_STBD_DIR"] = -1.0
    return {name: float(f"{value:.5g}") for name, value in out.items()}


def param_file(values: dict[str, float], head: str) -> str:
    """A file for Mission Planner, MAVProxy and `flotillad`: a name and a value a line."""
    return f"# {head}\n" + "".join(f"{name} {value:g}\n" for name, value in values.items())


def qgc_file(values: dict[str, float], head: str) -> str:
    """The same for QGroundControl: system, component, name, value, MAV_PARAM_TYPE a line."""
    lines = (f"1\t1\t{name}\t{value:g}\t9\n" for name, value in values.items())
    return f"# {head}\n" + "".join(lines)
