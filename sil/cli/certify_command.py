# SPDX-License-Identifier: MIT
"""Checks, before sailing, whether the boats of a scenario hold their formation.

Computes the paper's conditions, the Floquet multipliers of its periodic system and of every boat's
sampled closed loop, the thrust that the slots need, the greatest depth of a chain of boats, and
faster gains. Leaves tables, pictures and a verdict. Exit status: 0 certified, 1 not certified, 2
after a mistake of the caller.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from sil.common.out_folder import claim
from sil.scenario import arguments

if TYPE_CHECKING:
    from rich.console import Console

    from sil.certificate.certificate import Certificate
    from sil.scenario.scenario import Scenario

EXAMPLES = ("flotilla certify diamond", "flotilla certify line20 --param SR_STATE=5")


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_to(parser, out="folder of the results (out/certify/SCENARIO)")
    parser.add_argument(
        "--json", type=Path, metavar="FILE", help="also write certificate.json to FILE"
    )


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Compute, print and write the certificate."""
    from rich.console import Console

    from sil.certificate import certificate_files, certificate_report, certified_fleet, verdict
    from sil.scenario import scenario

    overrides = list(options.set)
    if options.seed is not None:
        overrides.append(f"seed={options.seed}")
    console = Console()
    chosen = scenario.load(options.scenario, overrides, options.law)
    parameters = arguments.parameters_of(options.param)
    certified_fleet.parameters(
        chosen, parameters
    )  # refuses invalid parameters before the long computation
    folder = options.out or Path("out") / "certify" / chosen.name
    out = claim(folder, "certificate.json", chosen.name)
    certificate_files.check(out, options.json)
    certificate = _computed(chosen, parameters, console)
    certificate_files.write(certificate, out, options.json)
    certificate_report.tell(certificate, console)
    console.print(f"results: {out}/certificate.html", soft_wrap=True, markup=False)
    return 0 if verdict.holds(certificate) else 1


def _computed(
    chosen: "Scenario", parameters: dict[str, float], console: "Console"
) -> "Certificate":
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

    from sil.certificate.certificate import certify

    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=1.0)
        return certify(
            chosen,
            parameters,
            lambda what, share: bar.update(task, description=what, completed=share),
        )
