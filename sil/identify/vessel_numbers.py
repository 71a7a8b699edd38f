# SPDX-License-Identifier: MIT
"""The figures of a hull for its owner and for the firmware: newtons, kilograms, parameters."""

from dataclasses import dataclass

import numpy as np

from sil.identify.hull_terms import INDEX
from sil.identify.identification import Identification
from sil.identify.voyage_log import Array
from sil.plant.waves import WATER_KGPM3
from sil.scenario import presets
from sil.scenario.presets import Cruise, Preset
from sil.scenario.sections import Propellers, Vessel

SPEEDS_MPS = (0.5, 1.0)
RATES_RADPS = (0.1, 0.3)
_LEAST_D22 = 0.05  # 1/s: the law divides by it
_CRUISE_RADPS = 0.15
_DRAFT = 0.1  # of the length; only its product with the drag coefficient counts


@dataclass(frozen=True)
class Boat:
    """Values measured with scales. surge_mass_kg: VES_M11, the mass with the water's added mass."""

    mass_kg: float
    added: float = 0.05

    @property
    def surge_mass_kg(self) -> float:
        """Inertia in surge; a log determines all other values relative to it."""
        return self.mass_kg * (1.0 + self.added)


def drag_N(terms: Array, m11_kg: float, speed_mps: float) -> Array:
    """Drag ahead at a speed of terms (…, K), of the water and of still air."""
    drag: Array = m11_kg * (terms[..., INDEX["d11"]] + quadratic(terms) * speed_mps) * speed_mps
    return drag


def quadratic(terms: Array) -> Array:
    """Quadratic drag ahead over m11 of terms (…, K), of the water and of still air.

    Logs with little wind determine only the sum of both, and the hull's files have no wind force.
    """
    both: Array = terms[..., INDEX["d11_quadratic"]] + terms[..., INDEX["wind_x"]]
    return both


def yaw_moment_Nm(terms: Array, m11_kg: float, rate_radps: float, length_m: float) -> Array:
    """Moment that holds a yaw rate without way on, including that of the cross-flow."""
    crossflow = terms[..., INDEX["d22_quadratic"]] * length_m**3 / 32.0  # ∫ |x|³ dx / L
    linear, quadratic = terms[..., INDEX["d33"]], terms[..., INDEX["d33_quadratic"]]
    moment: Array = m11_kg * (linear + (quadratic + crossflow) * rate_radps) * rate_radps
    return moment


def working_speed_mps(found: Identification) -> float:
    """Median speed ahead while the propellers work; drag is linearised there."""
    u = np.concatenate([log.motion[:, 3] for log in found.logs])
    busy = np.concatenate([np.abs(log.commands).max(axis=1) > 0.05 for log in found.logs])
    ahead = u[busy & (u > 0.1)]
    return float(np.median(ahead)) if len(ahead) else 0.5


def hull_of(found: Identification, boat: Boat) -> Preset:
    """The hull for the simulation, and for the firmware at the logs' usual speed.

    Both models lack sideways drag that grows with speed; it is taken at that speed.
    """
    body, m11 = found.problem.body, boat.surge_mass_kg
    t = {name: float(found.fit.values[k]) for name, k in INDEX.items()}
    speed = working_speed_mps(found)
    draft = _DRAFT * body.length_m
    vessel = Vessel(
        m11=m11,
        m22=m11 * t["m22"],
        m33=m11 * t["m33"],
        m23=m11 * t["m23"],
        d11=m11 * t["d11"],
        d22=m11 * max(t["d22"] + t["d22_speed"] * speed, _LEAST_D22),
        d33=m11 * t["d33"],
        d11_quadratic=m11 * float(quadratic(found.fit.values)),
        d33_quadratic=m11 * t["d33_quadratic"],
        d33_speed=m11 * t["d33_speed"],
        crossflow_cd=2.0 * m11 * t["d22_quadratic"] / (body.length_m * WATER_KGPM3 * draft),
        length_m=body.length_m,
        draft_m=draft,
    )
    propellers = Propellers(
        arm_m=body.arm_m,
        forward_max_N=m11 * t["forward"],
        reverse_max_N=m11 * t["forward"] * t["reverse"],
        expo=t["expo"],
        lag_s=t["lag"] + t["dead_time"],
        port_gain=1.0 - t["gain"],
        stbd_gain=1.0 + t["gain"],
        dead=t["dead"],
    )
    cruise = Cruise(speed_mps=speed, yaw_rate_radps=_CRUISE_RADPS)
    return Preset(sources={}, cruise=cruise, vessel=vessel, propellers=propellers)


def parameters(found: Identification, boat: Boat) -> dict[str, float]:
    """The firmware's parameters for this hull."""
    hull = hull_of(found, boat)
    own = presets.firmware(hull)
    own["THR_BALANCE"] = hull.propellers.stbd_gain - 1.0
    # Latencies are relative to the heading's, so they do not determine NAV_LAG_S.
    for name, k in (("NAV_OFS_X", INDEX["antenna_x"]), ("NAV_OFS_Y", INDEX["antenna_y"])):
        if found.intervals.determined[k]:
            own[name] = found.fit.values[k]
    if found.wiring.port_inverted:
        own["THR_PORT_DIR"] = -1.0
    if found.wiring.stbd_inverted:
        own["THR_STBD_DIR"] = -1.0
    return {name: float(f"{value:.4g}") for name, value in own.items()}


def hull_file(hull: Preset, head: str) -> str:
    """The hull as a file for `hull = "PATH"` in a scenario."""
    lines = ["# SPDX-License-Identifier: MIT", f"# {head}", "", "[sources]"]
    for part in ("cruise", "vessel", "propellers"):
        lines += ["", f"[{part}]"]
        lines += [f"{key} = {value:.5g}" for key, value in getattr(hull, part)]
    return "\n".join(lines) + "\n"
