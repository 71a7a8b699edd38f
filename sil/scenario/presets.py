# SPDX-License-Identifier: MIT
"""Hulls by name: `sil/hulls/NAME.toml` has a boat's numbers, each with its source or "estimate".

What a firmware without these terms is told is the drag of a straight line through them at cruise,
and in sway at the drift of a steady turn there:

d̂11 = X(U)/U   d̂33 = N(r)/r at U   d̂22 = Y(v)/v, with Y(v) = m11 U r

U, r: speed and yaw rate at cruise; X, Y, N the hull's drag (`sil.plant.hull`) at these.
"""

import difflib
import tomllib
from functools import cache
from pathlib import Path

from sil import ROOT
from sil.plant.hull import PAPER, HullParameters
from sil.scenario.gains import gains
from sil.scenario.sections import Positive, Propellers, Section, Vessel
from sil.scenario.toml_errors import ScenarioError

FOLDER = ROOT / "sil" / "hulls"
_ITERATIONS = 60


class Cruise(Section):
    """The speed and the yaw rate (m/s, rad/s) for which the firmware's drag is right."""

    speed_mps: Positive
    yaw_rate_radps: Positive


class Preset(Section):
    """A hull's file; the comments behind its numbers begin with a name in `sources`."""

    sources: dict[str, str]
    cruise: Cruise
    vessel: Vessel
    propellers: Propellers


def names() -> list[str]:
    """The hulls there are."""
    return sorted(path.stem for path in FOLDER.glob("*.toml"))


def path_of(name: str) -> Path:
    """The file of a hull; ScenarioError for a name that none has."""
    known = names()
    if name not in known:
        near = difflib.get_close_matches(name, known, 1)
        hint = f'did you mean "{near[0]}"? There' if near else "there"
        raise ScenarioError(f'unknown hull "{name}"; {hint} are {", ".join(known)}')
    return FOLDER / f"{name}.toml"


@cache
def load(name: str) -> Preset:
    """The hull of that name; ScenarioError as `path_of`."""
    return Preset.model_validate(tomllib.loads(path_of(name).read_text(encoding="utf-8")))


def firmware(preset: Preset) -> dict[str, float]:
    """The firmware's parameters for a boat with this hull: VES_*, THR_*, BOAT_LEN, LAW_*."""
    model, pair = linear(preset), preset.propellers
    own = {f"VES_{name.upper()}": getattr(model, name) for name in PAPER}
    own |= {
        "THR_ARM": pair.arm_m,
        "THR_FWD_MAX": pair.forward_max_N,
        "THR_REV_MAX": pair.reverse_max_N,
        "THR_EXPO": pair.expo,
        "THR_DEAD": pair.forward_max_N * pair.dead * (1.0 - pair.expo * (1.0 - pair.dead)),
    }
    if preset.vessel.length_m:
        own["BOAT_LEN"] = preset.vessel.length_m
    own |= gains(model, pair, preset.vessel.length_m)
    return {name: float(f"{value:.4g}") for name, value in own.items()}


def linear(preset: Preset) -> HullParameters:
    """The hull with the paper's six terms alone, its drag that of a line through cruise."""
    hull, u, r = preset.vessel.hull, preset.cruise.speed_mps, preset.cruise.yaw_rate_radps
    half = 0.5 * hull.length_m
    swing = 0.5 * hull.crossflow * half**4 * r  # of ∫ |x r| x² dx
    v, d22 = 0.0, hull.d22
    for _ in range(_ITERATIONS):  # a contraction: more drift, more drag
        d22 = hull.d22 + hull.crossflow * hull.length_m * v
        v = 0.5 * (v + hull.m11 * u * r / d22)
    return HullParameters(
        hull.m11,
        hull.m22,
        hull.m33,
        hull.d11 + hull.d11_quadratic * u,
        d22,
        hull.d33 + hull.d33_quadratic * r + hull.d33_speed * u + swing,
    )
