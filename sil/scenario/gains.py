# SPDX-License-Identifier: MIT
"""LAW_* gains from a hull and its propellers (placeholder rule: found by search)."""

from sil.plant.hull import HullParameters
from sil.scenario.sections import Propellers


def gains(model: HullParameters, pair: Propellers, length_m: float) -> dict[str, float]:
    """LAW_* of a boat."""
    return {}
