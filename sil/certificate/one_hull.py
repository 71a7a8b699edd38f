# SPDX-License-Identifier: MIT
"""The certificate of a hull: four boats of it in a diamond, behind an S-curve at its cruise."""

import math
from pathlib import Path

from sil.certificate import verdict
from sil.certificate.certificate import Progress, certify
from sil.scenario import presets, scenario

_HEADING_RAD = 0.6  # amplitude of the S-curve
_SPACING = 3.0  # hull lengths


def fits(hull: Path, overrides: dict[str, float], progress: Progress) -> tuple[bool, str]:
    """Whether the gains that the firmware derives fit the hull of a file, and the verdict.

    `overrides`: parameters of the firmware beside those that the hull gives. The loops are examined
    in calm water, without chains of boats.
    """
    chosen = presets.load(str(hull))
    speed, rate = chosen.cruise.speed_mps, chosen.cruise.yaw_rate_radps
    leader = scenario.load("mixed").hulls()[0]
    omega = rate / _HEADING_RAD
    curve = {
        "surge_N": leader.d11 * speed,
        "yaw_sine_Nm": math.hypot(leader.d33, leader.m33 * omega) * rate,
        "yaw_sine_rad_s": omega,
    }
    boats = scenario.load(
        "mixed",
        [
            *(f"boat.{number}.hull='{hull}'" for number in range(1, 5)),
            f"formation.spacing_m={_SPACING * chosen.vessel.length_m:g}",
            *(f"leader.input.1.{key}={value:.6g}" for key, value in curve.items()),
        ],
    )
    found = certify(boats, overrides, progress, loops_only=True)
    return verdict.holds(found), verdict.sentence(found)
