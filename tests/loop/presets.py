# SPDX-License-Identifier: MIT
"""Fleets of the hulls in sil/hulls behind an S-curve: RMS distance from their slots, worst boat.

    python -m tests.loop.presets

Four of each in a diamond, and `mixed`: in calm water with exact states, then with the noise of
`noisy`, 0.1 m/s of current and 3 m/s of wind with gusts, and in that the worst of 20 fleets whose
hulls differ from the firmware's by up to 30 %. The leader is the paper's vessel at the hull's
cruise. All parameters but the hull's are the firmware's defaults.
"""

import math
from collections.abc import Collection

import flotilla
import numpy as np

from sil.lockstep import metrics
from sil.lockstep.world import Run, all_sailed, sail
from sil.plant.hull import Array
from sil.scenario import presets, scenario
from sil.scenario.scenario import Scenario

BOATS, RUNS = 4, 20
_HEADING_RAD = 0.6  # amplitude of the S-curve
_SPACING = 3.0  # hull lengths
SHORTEST_M = 1.3  # BOAT_LEN's default: the paper's vessel has no length
GUARD = 1.2  # FS_SEP_M's default, hull lengths
GAINS = ("KDU", "KDR", "OBS_BW", "CUR_BW", "XT_DIST", "R_MAX")
#: Gains of a boat of 1 kg.
OF_THE_PAPERS_HULL = dict(
    zip((f"LAW_{name}" for name in GAINS), (10.0, 10.0, 2.0, 0.1, 1.0, 0.8), strict=True)
)
LEADER = scenario.load("mixed").hulls()[0]
WEATHER = (
    "navigation.rate_hz=20",
    "navigation.position_noise_m=0.02",
    "navigation.heading_noise_rad=0.0087",
    "navigation.velocity_noise_mps=0.02",
    "navigation.yaw_rate_noise_radps=0.0035",
    "water.current_mps=[0.0,0.1]",
    "wind.mean_mps=[-2.1,2.1]",
    "wind.gust_mps=0.5",
)


def alike(name: str) -> list[str]:
    """Overrides that make `mixed` a fleet of one hull, behind an S-curve of its cruise.

    The leader is the paper's vessel, which keeps to its course by itself. A Heron does not: behind
    a virtual one, whose propellers swing about straight ahead, the fleet sails in circles.
    """
    hull = presets.load(name)
    speed, rate = hull.cruise.speed_mps, hull.cruise.yaw_rate_radps
    omega = rate / _HEADING_RAD
    spacing = _SPACING * max(hull.vessel.length_m, SHORTEST_M)
    curve = {
        "surge_N": LEADER.d11 * speed,
        "yaw_sine_Nm": math.hypot(LEADER.d33, LEADER.m33 * omega) * rate,
        "yaw_sine_rad_s": omega,
    }
    return [
        *(f"boat.{number}.hull={name}" for number in range(1, BOATS + 1)),
        f"formation.spacing_m={spacing:g}",
        *(f"leader.input.1.{key}={value:.6g}" for key, value in curve.items()),
    ]


def length_m(hull: str) -> float:
    """The length that a hull's boats are told."""
    return presets.load(hull).vessel.length_m or SHORTEST_M


def fleets() -> dict[tuple[str, str], Scenario]:
    """Scenarios by the fleet, a hull's name or "mixed", and the weather."""
    kinds = {name: alike(name) for name in presets.names()} | {"mixed": []}
    return {
        (fleet, weather): scenario.load("mixed", [*changes, *more])
        for fleet, changes in kinds.items()
        for weather, more in (("calm", ()), ("weather", WEATHER))
    }


def worst_rms_m(error: Array) -> float:
    """The worst boat's RMS distance from its slot in the last third; error (T, N, 3)."""
    distance = metrics.distances(error)
    last = distance[len(distance) * 2 // 3 :]
    return float(np.sqrt((last**2).mean(axis=0)).max())


def rms_m(run: Run) -> float:
    """The same of a run in which all boats must be in FORMATION."""
    assert all(set(states) <= {"FORMATION", "APPROACH"} for states in run.states), run.states
    return worst_rms_m(run.trace["error"])


def varied(name: str) -> float:
    """RMS of the worst of `RUNS` fleets of a hull in the weather, six numbers up to 30 % off."""
    changes = [*alike(name), *WEATHER, "mismatch.share=0.3"]
    every = [scenario.load("mixed", [*changes, f"seed={seed}"]) for seed in range(1, RUNS + 1)]
    return max(map(rms_m, all_sailed(sail(every, {}))))


def measured(
    parameters: dict[str, float], only: Collection[tuple[str, str]] = ()
) -> dict[tuple[str, str], float]:
    """RMS of every fleet of `fleets`, or of those of `only`; RunError where one does not sail.

    `parameters`: of all boats, instead of their hulls'.
    """
    found = {key: fleet for key, fleet in fleets().items() if not only or key in only}
    runs = all_sailed(sail(list(found.values()), parameters))
    return {key: rms_m(run) for key, run in zip(found, runs, strict=True)}


def main() -> None:
    """Print the table, with the gains."""
    found, other = measured({}), measured(OF_THE_PAPERS_HULL)
    names = " | ".join(f"`LAW_{name}`" for name in GAINS)
    print(f"| fleet | {names} | calm, m | weather, m | ±30 %, m | calm, gains of 1 kg, m |")
    print("|---|" + "--:|" * (len(GAINS) + 4))
    for fleet in (*presets.names(), "mixed"):
        alone = fleet in presets.names()
        own = flotilla.derived(presets.firmware(presets.load(fleet))) if alone else {}
        cells = [f"{own[f'LAW_{name}']:.4g}" if alone else "–" for name in GAINS]
        cells += [f"{found[fleet, weather]:.4f}" for weather in ("calm", "weather")]
        cells += [f"{varied(fleet):.4f}" if alone else "–", f"{other[fleet, 'calm']:.4f}"]
        print(f"| `{fleet}` | {' | '.join(cells)} |")


if __name__ == "__main__":
    main()
