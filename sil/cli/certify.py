# SPDX-License-Identifier: MIT
"""Says before a scenario is sailed whether its boats hold their formation.

The paper's formulas, the Floquet multipliers of its periodic system, those of every boat's sampled
closed loop, what its propellers must give, how deep a chain of boats may be, and faster gains:
tables, pictures, a verdict.
"""

import argparse
import sys
from pathlib import Path

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn

from sil.certificate import certificate_files, certificate_report, verdict
from sil.certificate.certificate import Certificate, certify
from sil.certificate.certified_fleet import parameters as firmware_parameters
from sil.scenario import scenario
from sil.scenario.arguments import parameters_of
from sil.scenario.law import LAWS


def main(arguments: list[str]) -> int:
    """Exit status: 0 certified, 1 not, 2 a mistake of the caller, told in one line, 130 Ctrl-C."""
    options = _parser().parse_args(arguments)
    overrides = list(options.set)
    if options.seed is not None:
        overrides.append(f"seed={options.seed}")
    console = Console()
    try:
        chosen = scenario.load(options.scenario, overrides, options.law)
        parameters = parameters_of(options.param)
        firmware_parameters(chosen, parameters)
        out = options.out or Path("out") / "certify" / chosen.name
        certificate_files.check(out, options.json)
        certificate = _computed(chosen, parameters, console)
        certificate_files.write(certificate, out, options.json)
    except (ValueError, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted", file=sys.stderr)
        return 130
    certificate_report.tell(certificate, console)
    console.print(f"results: {out}/certificate.json, {out}/decay.png, chain.png", soft_wrap=True)
    return 0 if verdict.holds(certificate) else 1


def _computed(
    chosen: scenario.Scenario, parameters: dict[str, float], console: Console
) -> Certificate:
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task("", total=1.0)
        return certify(
            chosen,
            parameters,
            lambda what, share: bar.update(task, description=what, completed=share),
        )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="tools/certify", description=__doc__)
    parser.add_argument("scenario", help="a name in sil/scenarios, or the path of a .toml file")
    parser.add_argument(
        "--json", type=Path, metavar="FILE", help="write certificate.json there too"
    )
    parser.add_argument("--out", type=Path, help="folder of the results (out/certify/SCENARIO)")
    parser.add_argument("--seed", type=int, help="seed of every random number (the scenario's)")
    parser.add_argument("--law", choices=LAWS, help="as python -m sil run takes it")
    for name, form, text in (
        ("--param", "NAME=VALUE", "a firmware parameter of every boat; repeatable"),
        ("--set", "KEY=VALUE", "a key of the scenario, as link.delay_s=0.1; repeatable"),
    ):
        parser.add_argument(name, action="append", default=[], metavar=form, help=text)
    return parser


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
