# SPDX-License-Identifier: MIT
"""The command line: python -m sil run SCENARIO, … live SCENARIO --bus BUS, … results."""

import argparse
import shlex
import sys
from pathlib import Path

import can
from rich.console import Console

from sil import results, scenario
from sil.law import LAWS
from sil.run import live, parameters_of, run
from sil.world import StartError


def main(arguments: list[str]) -> int:
    """Exit status: 0, or 2 for a mistake of the caller, told in one line."""
    parser = argparse.ArgumentParser(prog="python -m sil", description=__doc__)
    commands = parser.add_subparsers(dest="command", required=True)
    lockstep = commands.add_parser("run", help="sail a scenario in lockstep, as fast as it goes")
    in_real_time = commands.add_parser(
        "live", help="sail a scenario in real time, a flotillad process a boat"
    )
    for command in (lockstep, in_real_time):
        _add_common(command)
    in_real_time.add_argument(
        "--bus",
        required=True,
        metavar="mcast:N|socketcan:NAMEn",
        help="bus of boat 1, as mcast:0 or socketcan:vcan0; boat i takes the next one",
    )
    in_real_time.add_argument("--duration", type=float, help="seconds (the scenario's)")
    results.add_to(commands)
    options = parser.parse_args(arguments)
    if options.command == "results":
        return results.main(options)
    overrides = list(options.set)
    if options.seed is not None:
        overrides.append(f"seed={options.seed}")
    if options.command == "live" and options.duration is not None:
        overrides.append(f"duration_s={options.duration}")
    try:
        chosen = scenario.load(options.scenario, overrides, options.law)
        out = options.out or Path("out") / chosen.name
        parameters = parameters_of(options.param)
        repeat = shlex.join(["python", "-m", "sil", *arguments])
        if options.command == "run":
            run(chosen, out, parameters, repeat, Console())
        else:
            live(chosen, options.bus, out, parameters, repeat, Console())
    except (ValueError, OSError, StartError, can.CanError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


def _add_common(command: argparse.ArgumentParser) -> None:
    command.add_argument("scenario", help="a name in sil/scenarios, or the path of a .toml file")
    command.add_argument("--out", type=Path, help="folder of the results (out/SCENARIO)")
    command.add_argument("--seed", type=int, help="seed of every random number (the scenario's)")
    command.add_argument(
        "--law",
        choices=LAWS,
        help="in place of the scenario's LAW_* but LAW_KDU and LAW_KDR, which belong to its vessel",
    )
    command.add_argument(
        "--param",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="a firmware parameter of every boat; repeatable",
    )
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="a key of the scenario, as link.delay_s=0.1 or boat.2.eta=[0,0,0]; repeatable",
    )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
