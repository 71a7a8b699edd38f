# SPDX-License-Identifier: MIT
"""The product's law at the settings of the scenarios' files must not get worse.

The published table sails at the firmware's defaults. It once sailed these scenarios as their files
are, at 100 Hz, 50 N and without a slew limit; the figures of then may improve, not get worse.
"""

import math
from functools import cache

import pytest

from sil.lockstep.world import all_sailed, sail
from sil.results.claims import CLAIMS, PRODUCT, Bound
from sil.scenario import scenario

# share within which a figure counts as equal; m: resolution of the reference is 1 mm
SHARE, WIRE_M = 1e-3, 2e-4
SEEDS = 40
FIGURES = {
    "diamond": {"rms_error_m": 5.94847e-05, "settling_s": 28.56},
    "tree": {"rms_error_m": 0.000270104},
    "straight": {"rms_error_m": 0.00119919},
    "current": {"rms_error_m": 0.0184052},
    "weak_link": {"rms_error_m": 0.0176706},
    "noisy": {"rms_error_m": 0.0149072, "thrust_change_N": 0.185532},
    "limits": {"rms_error_m": 0.000633856, "overshoot_m": 0.000893884},
    "turning": {"rms_error_m": 0.011972, "overshoot_m": 0.0386895},
    "stop_and_go": {
        "rms_error_m": 5.62262e-05,
        "overshoot_m": 0.0119237,
        "turns_at_a_stop": 0.0769026,
    },
    "sea": {"rms_error_m": 0.0793548},
}
EACH_PUSH = ("diamond", "noisy", "turning", "stop_and_go")
# Before boats steered by the reference: 0.0707874 m.
OF_MANY_SEEDS = {"mismatch": {"rms_error_m": 0.0760041, "thrust_rms_N": 2.78305}}
# Each boat closes up to its slot relative to the root; its distance from its leader, who closes
# up too, may grow meanwhile: accept these values.
WORSE = {("turning", "overshoot_m"): 0.665, ("stop_and_go", "overshoot_m"): 0.0715}


@cache
def figures_of(name: str, seed: int | None = None) -> dict[str, float]:
    seeds = [] if seed is None else [f"seed={seed}"]
    (run,) = all_sailed(sail([scenario.load(name, seeds, PRODUCT)], {}))
    of_product: list[Bound] = [b for b in CLAIMS[name].bounds if PRODUCT in b.laws]
    return {bound.key: bound.figure(run.trace) for bound in of_product}


@pytest.mark.parametrize(
    ("name", "key"),
    [
        pytest.param(name, key, marks=() if name in EACH_PUSH else pytest.mark.nightly)
        for name, figures in FIGURES.items()
        for key in figures
    ],
)
def test_figure_is_no_worse_than_it_was(name: str, key: str) -> None:
    floor = WIRE_M if key.endswith("_m") else 0.0
    was = WORSE.get((name, key), FIGURES[name][key])
    assert figures_of(name)[key] <= was * (1.0 + SHARE) + floor


@pytest.mark.nightly
@pytest.mark.parametrize("name", OF_MANY_SEEDS)
def test_95th_percentile_is_no_worse_than_it_was(name: str) -> None:
    runs = [figures_of(name, seed) for seed in range(1, SEEDS + 1)]
    for key, figure in OF_MANY_SEEDS[name].items():
        now = sorted(run[key] for run in runs)[math.ceil(0.95 * (SEEDS - 1))]
        assert now <= figure * (1.0 + SHARE), key
