# SPDX-License-Identifier: MIT
"""Identifies a hull from logs of its sailing: inertias, drag, propellers, compass.

Reads CSV files with named columns, tlogs and ArduPilot's .bin; writes a parameter file and a page.
Weigh the boat, and measure its length and the distance between its propellers: logs alone determine
ratios only. Also certifies whether the gains that the firmware derives fit the hull. Exit status:
0; 1 if the hull does not predict the half of the logs to which it was not fitted, or if the gains
do not fit; 2 after a mistake of the caller.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

from sil.common.out_folder import claim
from sil.scenario.arguments import nonempty_path

EXAMPLES = (
    "flotilla identify voyage.csv --mass 17 --length 1.2 --arm 0.28",
    "flotilla identify logs/*.tlog --mass 55 --length 2 --arm 0.4 --out out/otter",
)

# kg/m³, mass over the cube of the length: 1.5 to 13 for the preset hulls, 0.2 for a racing kayak.
_LIGHT, _HEAVY = 0.03, 150.0


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("logs", nargs="+", type=Path, metavar="LOG")
    parser.add_argument(
        "--mass", type=_positive, required=True, help="mass of the boat ready to sail, kg"
    )
    parser.add_argument("--length", type=_positive, required=True, help="length of the hull, m")
    parser.add_argument(
        "--arm", type=_positive, required=True, help="half the distance between the propellers, m"
    )
    parser.add_argument(
        "--out",
        type=nonempty_path,
        default=Path("out/identify"),
        help="folder of the results (out/identify)",
    )


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Identify it, print the figures and write the files."""
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn

    from sil.certificate import one_hull
    from sil.common import files
    from sil.identify import identify_files, identify_report
    from sil.identify.identification import identify
    from sil.identify.log_files import read
    from sil.identify.vessel_numbers import Boat, parameters
    from sil.identify.voyage_log import SAMPLE_S
    from sil.identify.voyage_model import Body

    console = Console()
    boat = Boat(options.mass)
    _check_sizes(options, boat.surge_mass_kg)
    body = Body(arm_m=options.arm, length_m=options.length, h_s=SAMPLE_S)
    out = claim(options.out, "identify.json", "identify")
    files.check_folder(out, out)
    logs, notes = read(options.logs)
    columns = (TextColumn("{task.description}"), BarColumn(), TaskProgressColumn())
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bar:
        task = bar.add_task("identifying", total=1.0)
        found = identify(logs, body, lambda share: bar.update(task, completed=share))
        hull = identify_files.write_hull(found, boat, out)
        fit = None
        if hull:
            bar.update(task, description="certifying", completed=0.0)
            balance = {"THR_BALANCE": parameters(found, boat)["THR_BALANCE"]}
            fit = one_hull.fits(
                out / "hull.toml", balance, lambda _, share: bar.update(task, completed=share)
            )
    identify_report.tell(found, boat, fit, console)
    for note in notes:
        console.print(note, style="dim", markup=False)
    for path in [*identify_files.write(found, boat, fit, out), *hull]:
        console.print(f"results: {path}", soft_wrap=True, markup=False)
    return 0 if identify_report.holds(found) and (fit is None or fit[0]) else 1


def _check_sizes(options: argparse.Namespace, surge_mass_kg: float) -> None:
    """ValueError if the firmware has no parameter for this size, or two sizes contradict."""
    import flotilla

    ranges = {one["name"]: (one["least"], one["greatest"]) for one in flotilla.parameter_list()}
    for option, value, name, unit in (
        ("mass", surge_mass_kg, "VES_M11", "kg"),
        ("length", options.length, "BOAT_LEN", "m"),
        ("arm", options.arm, "THR_ARM", "m"),
    ):
        least, greatest = ranges[name]
        if not least <= value <= greatest:
            raise ValueError(
                f"--{option} {getattr(options, option):g}: {name} is from {least:.3g} to "
                f"{greatest:.6g} {unit}; is the value in {unit}?"
            )
    per_cube = options.mass / options.length**3
    if not _LIGHT <= per_cube <= _HEAVY:
        word = "heavy" if per_cube > _HEAVY else "light"
        raise ValueError(
            f"--mass {options.mass:g} is too {word} for --length {options.length:g}: "
            "the mass is in kg, the length of the hull in m"
        )
    if options.arm > options.length:
        raise ValueError(
            f"--arm {options.arm:g} is more than --length {options.length:g}: both are in metres, "
            "and the arm is half the distance between the propellers"
        )


def _positive(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text} is not a number; write it without a unit"
        ) from None
    if not 0.0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not a positive number")
    return value
