# SPDX-License-Identifier: MIT
"""The command line: python -m sil run SCENARIO."""

import argparse
import shlex
import sys
from pathlib import Path

from rich.console import Console

from sil import scenario
from sil.run import parameters_of, run
from sil.world import StartError


def main(arguments: list[str]) -> int:
    """Exit status: 0, or 2 for a mistake of the caller, told in one line."""
    parser = argparse.ArgumentParser(prog="python -m sil", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    sail = commands.add_parser("run", help="sail a scenario in lockstep, as fast as it goes")
    sail.add_argument("scenario", help="a name in sil/scenarios, or the path of a .toml file")
    sail.add_argument("--out", type=Path, help="folder of the results (out/SCENARIO)")
    sail.add_argument("--seed", type=int, help="seed of every random number (the scenario's)")
    sail.add_argument(
        "--param",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a firmware parameter of every boat; repeatable",
    )
    sail.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="a key of the scenario, as link.delay_s=0.1 or boat.2.eta=[0,0,0]; repeatable",
    )
    options = parser.parse_args(arguments)
    overrides = options.set + ([f"seed={options.seed}"] if options.seed is not None else [])
    try:
        chosen = scenario.load(options.scenario, overrides)
        run(
            chosen,
            options.out or Path("out") / chosen.name,
            parameters_of(options.param),
            shlex.join(["python", "-m", "sil", *arguments]),
            Console(),
        )
    except (ValueError, StartError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
