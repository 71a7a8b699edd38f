# SPDX-License-Identifier: MIT
"""Gains that the firmware derives for hulls of 1 to 800 kg, and how fleets of them sail.

    python -m tests.loop.gains [HULL…]

Four of a kind in a diamond, slots three hull lengths apart, behind an S-curve of one of their kind
at cruise, in calm water with exact states. The boats are told their hull (VES_*), propellers
(THR_*) and length, no LAW_*: first with the lag of their propellers, then without, and at last with
the numbers that belong to the paper's hull. `certificate`: decay of small errors of the slowest
boat's sampled loop.
"""

import argparse
from dataclasses import dataclass

import flotilla
import numpy as np
from rich.console import Console
from rich.table import Table

from sil.certificate.certified_fleet import fleet, parameters
from sil.certificate.references import references
from sil.certificate.sampled import sampled_loop
from sil.certificate.thrust import thrust_need
from sil.lockstep.world import Run, sail
from sil.scenario import presets, scenario
from sil.scenario.presets import Preset
from sil.scenario.scenario import Scenario
from tests.loop.presets import BOATS, alike

DERIVED = ("LAW_KDU", "LAW_KDR", "LAW_OBS_BW", "LAW_XT_DIST", "LAW_CUR_BW", "LAW_R_MAX")
#: Defaults of all boats before they were derived.
OF_THE_PAPERS_HULL = dict(zip(DERIVED, (10.0, 10.0, 2.0, 1.0, 0.1, 0.8), strict=True))
_PLACES = {"LAW_KDU": 1, "LAW_KDR": 1, "LAW_XT_DIST": 2}


@dataclass(frozen=True)
class Found:
    """How a fleet sailed: worst RMS in the last third, m, or the first state that ended it."""

    rms_m: float
    left: str

    @property
    def text(self) -> str:
        """For the table."""
        return self.left or f"{self.rms_m:.4f}"


def told(preset: Preset) -> dict[str, float]:
    """What the owner of such a boat tells its firmware: hull, propellers, length, no gains."""
    own = {name: value for name, value in presets.firmware(preset).items() if name[:4] != "LAW_"}
    hull = preset.vessel.hull
    speed = hull.d33_speed * preset.cruise.speed_mps
    quadratic = hull.d11_quadratic * preset.cruise.speed_mps
    own["VES_D33"] = max(own["VES_D33"] - speed, 0.001)
    own["VES_D11"] = max(own["VES_D11"] - quadratic, 0.01)
    return own | {
        "VES_D33U": hull.d33_speed,
        "VES_D11Q": hull.d11_quadratic,
        "THR_LAG": preset.propellers.lag_s,
        "THR_BALANCE": 0.5 * (preset.propellers.stbd_gain - preset.propellers.port_gain),
    }


def fleet_of(name: str, own: dict[str, float], more: dict[str, float]) -> Scenario:
    """Four boats of a hull with these parameters, no others of the law's."""
    given = {**dict.fromkeys(DERIVED, -1.0), **own, **more}
    changes = [
        f"boat.{boat}.parameters.{key}={value!r}"
        for boat in range(1, BOATS + 1)
        for key, value in given.items()
    ]
    return scenario.load("mixed", [*alike(name), *changes])


def sailed(fleets: list[Scenario]) -> list[Found]:
    """Sail them all."""
    found = []
    for run in sail(fleets, {}):
        if not isinstance(run, Run):
            found.append(Found(float("nan"), str(run)))
            continue
        off_m = np.hypot(run.trace["error"][..., 0], run.trace["error"][..., 1])
        rms_m = np.sqrt((off_m[len(off_m) * 2 // 3 :] ** 2).mean(axis=0)).max()
        found.append(Found(float(rms_m), _left(run)))
    return found


def _left(run: Run) -> str:
    """When a boat ceased to follow, if one did."""
    for states in run.states:
        if not set(states) <= {"FORMATION", "APPROACH"}:
            return " ".join(dict.fromkeys(states))
    return ""


def certificate(boats: Scenario) -> str:
    """Decay of the slowest boat, or what is wrong."""
    (reference,) = references(boats)
    decays = []
    for _, slot, setup in fleet(boats, reference, parameters(boats, {})):
        if not thrust_need(slot, setup.propellers).given:
            return "thrust"
        loop, _ = sampled_loop(setup, False)
        if not loop.holds:
            return f"{loop.outcome}{'' if loop.steady else ', not steady'}"
        decays.append(loop.decay)
    return f"holds, {min(decays):.3f} 1/s"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("hulls", nargs="*", metavar="HULL", default=presets.names())
    parser.add_argument("--param", action="append", default=[], metavar="NAME=VALUE")
    options = parser.parse_args()
    more = {name: float(value) for name, _, value in (x.partition("=") for x in options.param)}
    table = Table(*("hull", "kg", "m", "lag, s"), *DERIVED, "certificate", "RMS, m")
    table.add_column("lag not told")
    table.add_column("as the paper's hull")
    for name in options.hulls:
        own = told(presets.load(name))
        fleets = [
            fleet_of(name, own, changed)
            for changed in (more, {**more, "THR_LAG": -1.0}, OF_THE_PAPERS_HULL)
        ]
        gains = flotilla.derived({**own, **more})
        cells = [f"{gains[gain]:.{_PLACES.get(gain, 3)}f}" for gain in DERIVED]
        hull = (own["VES_M11"], own.get("BOAT_LEN", 1.3), own["THR_LAG"])
        runs = [one.text for one in sailed(fleets)]
        table.add_row(name, *(f"{x:g}" for x in hull), *cells, certificate(fleets[0]), *runs)
    Console(width=220).print(table)


if __name__ == "__main__":
    main()
