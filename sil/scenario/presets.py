# SPDX-License-Identifier: MIT
"""Hulls by name: `sil/hulls/NAME.toml` has a boat's numbers, each with its source or "estimate".

The firmware, which has the paper's linear drag alone, is told straight lines through the hull's
drag in a steady turn at cruise:

d̂11 = X/U   d̂22 = Y/v   d̂33 = N/r,  v from Y = −m11 U r

U, r: speed and yaw rate at cruise; v: drift; X, Y, N: the hull's drag there (`sil.plant.hull`).
"""

import difflib
import math
import tomllib
from functools import cache
from pathlib import Path

import numpy as np

from sil import ROOT
from sil.plant.hull import PAPER, HullParameters
from sil.scenario.hull_gains import gains
from sil.scenario.sections import Positive, Propellers, Section, Vessel
from sil.scenario.toml_errors import ScenarioError

FOLDER = ROOT / "sil" / "hulls"
_ITERATIONS, _STRIPS = 60, 400
_OF_MOMENT, _RATE_MOST = 0.85, 0.8  # the firmware's default


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
        "THR_DEAD": 0.0,  # told of a dead band, it gives up what its observer finds it needs
    }
    if preset.vessel.length_m:
        own["BOAT_LEN"] = preset.vessel.length_m
    own |= gains(model, pair)
    own["LAW_R_MAX"] = greatest_rate(preset)
    return {name: float(f"{value:.4g}") for name, value in own.items()}


def linear(preset: Preset) -> HullParameters:
    """The hull with the paper's six terms alone, its drag that of a line through cruise."""
    hull, u, r = preset.vessel.hull, preset.cruise.speed_mps, preset.cruise.yaw_rate_radps
    x = hull.length_m * ((np.arange(_STRIPS) + 0.5) / _STRIPS - 0.5)
    v = d22 = swing = 0.0
    for _ in range(_ITERATIONS):  # a contraction: more drift, more drag
        v = 0.5 * (v - hull.m11 * u * r / (d22 or hull.d22))
        flow = v + x * r
        strips = hull.crossflow * np.abs(flow) * flow * hull.length_m / _STRIPS
        d22, swing = hull.d22 + float(strips.sum()) / v, float((strips * x).sum()) / r
    return HullParameters(
        hull.m11,
        hull.m22,
        hull.m33,
        hull.d11 + hull.d11_quadratic * u,
        d22,
        hull.d33 + hull.d33_quadratic * r + hull.d33_speed * u + swing,
    )


def greatest_rate(preset: Preset) -> float:
    """LAW_R_MAX: the yaw rate that the propellers hold at cruise with some of their moment left."""
    hull, pair = preset.vessel.hull, preset.propellers
    half = 0.5 * hull.length_m
    linear = hull.d33 + hull.d33_speed * preset.cruise.speed_mps
    quadratic = hull.d33_quadratic + 0.5 * hull.crossflow * half**4
    moment = _OF_MOMENT * pair.arm_m * (pair.forward_max_N + pair.reverse_max_N)
    rate = 2.0 * moment / (linear + math.sqrt(linear**2 + 4.0 * quadratic * moment))
    return min(_RATE_MOST, rate)
