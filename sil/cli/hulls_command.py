# SPDX-License-Identifier: MIT
"""Lists the hulls that a scenario may name, or prints one's parameters for the firmware.

`hull = "otter"` in a scenario, or in a boat's table, selects that hull. With a name, prints its
.param file, which Mission Planner, MAVProxy and flotillad load; with --format params, the file for
QGroundControl. The same files are in sil/hulls.
"""

import argparse
from collections.abc import Sequence

EXAMPLES = ("flotilla hulls", "flotilla hulls otter > otter.param")


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("hull", nargs="?", help="a name of the list")
    parser.add_argument(
        "--format", choices=("param", "params"), default="param", help="format of the file (param)"
    )


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Print the list or the file."""
    from sil.scenario import hull_files, presets

    if options.hull is not None:
        print(hull_files.texts(options.hull)[options.format], end="")
        return 0
    for name in presets.names():
        vessel = presets.load(name).vessel
        length = f"{vessel.length_m:6.3g} m" if vessel.length_m else f"{'–':>6}  "
        print(f"{name:10}{vessel.m11:8.4g} kg{length}  {hull_files.about(name)}")
    return 0
