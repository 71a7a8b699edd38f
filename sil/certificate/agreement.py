# SPDX-License-Identifier: MIT
"""Compares the certified depth of a chain with the depth at which it breaks in simulation.

    python -m sil.certificate.agreement line20 --param LAW_REF=0 [--law paper] [--delay S]...

Both apply the same limits to every boat: peak yaw rate and speed from 100 s on, and RMS distance
from the slot over the last third of the run. Exit status 1 if they differ by more than one boat, at
any of several delays.
"""

import argparse
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from rich.console import Console
from rich.table import Table

from sil.certificate.chain import Depth, chain
from sil.certificate.references import references
from sil.lockstep import metrics
from sil.lockstep.world import all_sailed, sail
from sil.scenario import scenario
from sil.scenario.arguments import parameters_of
from sil.scenario.law import LAWS, Law

DELAYS_S = (0.05, 0.1, 0.2)
_SETTLED_S, _KEEP_S = 100.0, 0.05


@dataclass(frozen=True)
class Depths:
    """Depths to which all boats keep the limits, at a radio delay."""

    delay_s: float
    certified: int
    sailed: int

    @property
    def agree(self) -> bool:
        """Whether the depths differ by at most one boat."""
        return abs(self.certified - self.sailed) <= 1


def compare(name: str, law: Law | None, parameters: dict[str, float], delay_s: float) -> Depths:
    """Certify a scenario's worst chain behind its first reference, and sail the scenario."""
    chosen = scenario.load(name, [f"link.delay_s={delay_s}"], law)
    found = chain(chosen, references(chosen)[0], parameters, most=len(chosen.boat))
    (run,) = all_sailed(sail([chosen], parameters, keep_s=_KEEP_S))
    trace = run.trace
    late = trace["t_s"] >= _SETTLED_S
    third = trace["t_s"] >= trace["t_s"][-1] * 2.0 / 3.0
    sailed = 0
    for agent in found.path:
        nu = trace["nu"][late, agent]
        off_m = metrics.distances(trace["error"][third, agent - 1])
        depth = Depth(
            float(np.abs(nu[:, 2]).max()),
            float(np.hypot(nu[:, 0], nu[:, 1]).max()),
            float(np.sqrt(np.mean(off_m**2))),
        )
        if not found.limits.holds(depth):
            break
        sailed += 1
    return Depths(delay_s, min(found.certified, len(found.path)), sailed)


def main(arguments: Sequence[str]) -> int:
    """Run the module's command line; exit status 0 if the depths agree, 1 if not."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("scenario")
    parser.add_argument("--law", choices=LAWS)
    parser.add_argument("--param", action="append", default=[], metavar="NAME=VALUE")
    parser.add_argument("--delay", action="append", type=float, metavar="S")
    options = parser.parse_args(arguments)
    parameters = parameters_of(options.param)
    table = Table("radio delay (s)", "certified depth", "holds in simulation to", "within one")
    agree = True
    for delay_s in options.delay or DELAYS_S:
        found = compare(options.scenario, options.law, parameters, delay_s)
        agree = agree and found.agree
        yes = "yes" if found.agree else "no"
        table.add_row(f"{delay_s:g}", str(found.certified), str(found.sailed), yes)
    Console().print(table)
    return 0 if agree else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
