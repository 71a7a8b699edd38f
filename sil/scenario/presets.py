# SPDX-License-Identifier: MIT
"""Hulls by name: `sil/hulls/NAME.toml` has a boat's numbers, each with its source or "estimate".

A hull of the user's own, such as the result of `flotilla identify`, is selected by the path of its
file.

The firmware gets the hull's drag ahead, and its yaw damping that grows with speed, unchanged. Its
model lacks the other nonlinear terms; for them it gets linear coefficients that match the hull's
drag in a steady turn at cruise:

    d̂11 = d11, d̂11q = d11q   d̂22 = Y/v   d̂33 = N/r − d33u U, d̂33u = d33u,   v from Y = −m11 U r

U, r: speed and yaw rate at cruise; v: drift; Y, N: the hull's drag there (`sil.plant.hull`). The
firmware derives the gains of the law from these numbers (`app/parameters/derived.hpp`).
"""

import difflib
from functools import cache
from pathlib import Path

import numpy as np
from pydantic import ValidationError

from sil import ROOT
from sil.plant.hull import PAPER, HullParameters
from sil.scenario.sections import Positive, Propellers, Section, Vessel
from sil.scenario.toml_errors import ScenarioError, Source

FOLDER = ROOT / "sil" / "hulls"
_ITERATIONS, _STRIPS = 60, 400
# Defaults of a scenario that are another boat's: a hull must have its own.
_OWN = {
    "vessel": ("m11", "m22", "m33", "d11", "d22", "d33"),
    "propellers": ("arm_m", "forward_max_N", "reverse_max_N"),
}
_LEAST_D = 0.01  # not below the least VES_D11 and VES_D33
DERIVED = (
    "LAW_KDU",
    "LAW_KDR",
    "LAW_OBS_BW",
    "LAW_CUR_BW",
    "LAW_XT_DIST",
    "LAW_R_MAX",
)


class Cruise(Section):
    """Speed (m/s) and yaw rate (rad/s) at which the firmware's linear drag equals the hull's."""

    speed_mps: Positive
    yaw_rate_radps: Positive


class Preset(Section):
    """A hull's file; the comment on each number begins with a name in `sources`."""

    sources: dict[str, str]
    cruise: Cruise
    vessel: Vessel
    propellers: Propellers


def names() -> list[str]:
    """The names of all hulls."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def is_known(name: object) -> bool:
    """Whether `name` is the name of a hull, or the path of a hull's file."""
    return isinstance(name, str) and (name in names() or Path(name).is_file())


def path_of(name: str) -> Path:
    """The file of a hull; ScenarioError if there is none with that name."""
    if name.endswith(".toml") and Path(name).is_file():
        return Path(name)
    if name.endswith(".toml"):
        raise ScenarioError(f'"{name}": no such file, relative to {Path.cwd()}')
    known = names()
    if name not in known:
        near = difflib.get_close_matches(name, known, 1)
        hint = f'did you mean "{near[0]}"? There' if near else "there"
        raise ScenarioError(f'unknown hull "{name}"; {hint} are {", ".join(known)}')
    return FOLDER / f"{name}.toml"


@cache
def load(name: str) -> Preset:
    """Read a hull; ScenarioError as `path_of`, or if the file is not a valid hull."""
    source = Source.read(path_of(name))
    try:
        hull = Preset.model_validate(source.document)
    except ValidationError as error:
        raise source.errors(error, Preset) from None
    for part, keys in _OWN.items():
        for key in keys:
            if key not in source.document[part]:
                raise source.error((part, key), f'missing key "{part}.{key}"')
    return hull


def firmware(preset: Preset) -> dict[str, float]:
    """The firmware's parameters for a boat with this hull: VES_*, THR_*, BOAT_LEN, gains derived.

    The gains are -1 (derive), so that no gain remains that was set for another hull.
    """
    model, pair = linear(preset), preset.propellers
    own = {f"VES_{name.upper()}": getattr(model, name) for name in PAPER}
    own |= {
        "VES_D11Q": model.d11_quadratic,
        "VES_D33U": model.d33_speed,
        "THR_ARM": pair.arm_m,
        "THR_FWD_MAX": pair.forward_max_N,
        "THR_REV_MAX": pair.reverse_max_N,
        "THR_EXPO": pair.expo,
        "THR_DEAD": 0.0,  # else the firmware drops thrusts that its observer demands
        "THR_LAG": pair.lag_s,
    }
    if preset.vessel.length_m:
        own["BOAT_LEN"] = preset.vessel.length_m
    own |= dict.fromkeys(DERIVED, -1.0)
    return {name: float(f"{value:.4g}") for name, value in own.items()}


def linear(preset: Preset) -> HullParameters:
    """The hull in the firmware's model: terms that the model lacks are linear, exact at cruise."""
    hull, u, r = preset.vessel.hull, preset.cruise.speed_mps, preset.cruise.yaw_rate_radps
    x = hull.length_m * ((np.arange(_STRIPS) + 0.5) / _STRIPS - 0.5)
    v = d22 = swing = 0.0
    for _ in range(_ITERATIONS):  # converges: more drift gives more drag
        v = 0.5 * (v - hull.m11 * u * r / (d22 or hull.d22 or _LEAST_D))
        flow = v + x * r
        strips = hull.crossflow * np.abs(flow) * flow * hull.length_m / _STRIPS
        d22, swing = hull.d22 + float(strips.sum()) / v, float((strips * x).sum()) / r
    return HullParameters(
        hull.m11,
        hull.m22,
        hull.m33,
        max(hull.d11, _LEAST_D),
        d22,
        max(hull.d33 + hull.d33_quadratic * r + swing, _LEAST_D),
        d11_quadratic=hull.d11_quadratic,
        d33_speed=hull.d33_speed,
    )
