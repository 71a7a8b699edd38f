# SPDX-License-Identifier: MIT
"""Gains that the firmware derives for hulls of 1 to 800 kg, and how fleets of them sail.

    python -m tests.loop.gains [HULL…]

Four of a kind in a diamond, slots three hull lengths apart, behind an S-curve at their cruise, in
calm water with exact states. The boats are told their hull (VES_*), propellers
(THR_*) and length, no LAW_*: first with the lag of their propellers, then without, and at last with
the numbers that belong to the paper's hull. `certificate`: decay of small errors of the slowest
boat's sampled loop.
"""

import argparse
from dataclasses import dataclass

import flotilla
from rich.console import Console
from rich.table import Table

from sil.certificate.certified_fleet import fleet, parameters
from sil.certificate.references import references
from sil.certificate.sampled import sampled_loop
from sil.certificate.thrust import thrust_need
from sil.lockstep.start import RunError
from sil.lockstep.world import Run, sail
from sil.scenario import presets, scenario
from sil.scenario.presets import DERIVED
from sil.scenario.scenario import Scenario
from tests.loop.presets import BOATS, OF_THE_PAPERS_HULL, alike, worst_rms_m

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


def fleet_of(name: str, own: dict[str, float], more: dict[str, float]) -> Scenario:
    """Four boats of a hull with these parameters."""
    given = {**own, **more}
    changes = [
        f"boat.{boat}.parameters.{key}={value!r}"
        for boat in range(1, BOATS + 1)
        for key, value in given.items()
    ]
    return scenario.load("mixed", [*alike(name), *changes])


def found_of(run: Run | RunError) -> Found:
    """How a fleet sailed."""
    if not isinstance(run, Run):
        return Found(float("nan"), str(run))
    return Found(worst_rms_m(run.trace["error"]), _left(run))


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
        own = presets.firmware(presets.load(name))
        fleets = [
            fleet_of(name, own, changed)
            for changed in (more, {**more, "THR_LAG": -1.0}, OF_THE_PAPERS_HULL)
        ]
        gains = flotilla.derived({**own, **more})
        cells = [f"{gains[gain]:.{_PLACES.get(gain, 3)}f}" for gain in DERIVED]
        hull = (own["VES_M11"], own.get("BOAT_LEN", 1.3), own["THR_LAG"])
        runs = [found_of(run).text for run in sail(fleets, {})]
        table.add_row(name, *(f"{x:g}" for x in hull), *cells, certificate(fleets[0]), *runs)
    Console(width=220).print(table)


if __name__ == "__main__":
    main()
