# SPDX-License-Identifier: MIT
"""Sails a scenario in real time, with one flotillad process and one CAN bus for each boat.

Exit status: 0; 1 if the verdict is red (a boat stopped, or two boats came nearer than a hull's
length), unless --gcs lets a ground station command the boats; 2 after a mistake of the caller, or
if a boat's process ended.
"""

import argparse
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

from sil.cli.run_command import leave_motion
from sil.common.out_folder import claim
from sil.scenario import arguments

EXAMPLES = (
    "flotilla live diamond",
    "tools/with-vcan flotilla live diamond --bus socketcan:vcan0",
    "flotilla live diamond --bus mcast:0 --mavlink mcast:    # and elsewhere: flotilla view mcast:",
    "flotilla live diamond --bus mcast:0 --gcs udpout:127.0.0.1:14550 --duration 3600",
)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    arguments.add_to(parser, out="folder of the results (out/SCENARIO_live)")
    parser.add_argument(
        "--bus",
        default="mcast:0",
        metavar="mcast:N|socketcan:NAMEn",
        help="bus of boat 1 (mcast:0), or socketcan:vcan0; the other boats take the next ones",
    )
    parser.add_argument(
        "--mavlink",
        metavar="mcast:[GROUP:PORT[:ADDRESS]]|udpout:HOST:PORT",
        help="repeat the radio's messages to this address, for flotilla view and ground stations",
    )
    parser.add_argument(
        "--gcs",
        metavar="udpout:HOST:PORT",
        help="let a ground station at this address command the boats: QGroundControl, "
        "MAVSDK and MAVProxy listen on 14550",
    )
    parser.add_argument("--duration", type=float, help="seconds (the scenario's)")


def main(options: argparse.Namespace, given: Sequence[str]) -> int:
    """Sail the scenario; `given`: the command line as the caller typed it."""
    import can
    from rich.console import Console

    from sil.lockstep.start import StartError
    from sil.report import headline, one_run
    from sil.scenario import scenario

    overrides = list(options.set)
    if options.seed is not None:
        overrides.append(f"seed={options.seed}")
    if options.duration is not None:
        overrides.append(f"duration_s={options.duration}")
    chosen = scenario.load(options.scenario, overrides, options.law)
    out = claim(options.out or Path("out") / f"{chosen.name}_live", "summary.json", chosen.name)
    parameters = arguments.parameters_of(options.param)
    console = Console()
    repeat = shlex.join(["flotilla", *given])
    links = options.mavlink, options.gcs
    try:
        summary = one_run.live(chosen, options.bus, out, parameters, repeat, console, *links)
    except (StartError, can.CanError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    (out / "run.mcap").unlink(missing_ok=True)  # left by an earlier run
    leave_motion(chosen, out, parameters, console)
    return int(options.gcs is None and headline.of_run(summary).level == "bad")
