# SPDX-License-Identifier: MIT
"""Examines a boat's computer: what keeps the boat from sailing, and the remedy.

It checks clock, disk and supply; the service, its files and their permissions; the CAN interface
and its motor controllers; the MAVLink links with their rates, latency and signatures. It commands
nothing. If flotillad runs, the doctor asks it; otherwise it listens to the links itself. With sudo
it can read all that the service reads.

Exit status: 0 if the boat is ready, 1 if something keeps it from sailing, 2 after a mistake of the
caller.
"""

import argparse
import json
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

EXAMPLES = (
    "sudo flotilla doctor",
    "flotilla doctor --config boat.toml --json",
    "sudo flotilla doctor --collect report.tar.gz    # logs and all, no keys: to report a fault",
)
_CONFIG = "/etc/flotilla/boat.toml"


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument(
        "--config", default=_CONFIG, metavar="FILE", help=f"configuration of flotillad ({_CONFIG})"
    )
    parser.add_argument(
        "--seconds",
        type=_seconds,
        default=4.0,
        metavar="S",
        help="seconds to listen to each bus (4)",
    )
    parser.add_argument("--json", action="store_true", help="print the findings as JSON")
    parser.add_argument(
        "--collect",
        type=Path,
        metavar="FILE.tar.gz",
        help="write findings, configuration, parameters, logs and versions, but no keys",
    )
    parser.add_argument("--user", default="flotilla", help="user that runs flotillad (flotilla)")
    parser.add_argument(
        "--root",
        type=Path,
        default=Path("/"),
        metavar="DIR",
        help="root of the files to examine, such as a boat's memory card in a reader",
    )


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Examine the computer and print the findings."""
    from sil.doctor import boat_file
    from sil.doctor.checkup import as_json, examine, lines
    from sil.doctor.collection import collect
    from sil.doctor.computer import Computer

    if not options.root.is_dir():
        raise ValueError(f"--root {options.root}: there is no such folder")
    computer = Computer(options.root, options.user)
    config = options.config
    if options.root == Path("/"):
        config = str(Path(config).absolute())
    findings = list(examine(computer, config, options.seconds))
    report = as_json(findings)
    if options.json:
        print(json.dumps(report, indent=1, ensure_ascii=False))
    else:
        print("\n".join(lines(findings)))
    if options.collect is not None:
        boat, _found = boat_file.read(computer, config)
        names = collect(computer, config, boat, findings, options.collect)
        if not options.json:
            print(f"\n{options.collect}: {len(names)} files, no keys")
    return 0 if report["ready"] else 1


def _seconds(text: str) -> float:
    """Parse a listening time in seconds; raise an argparse error if it is out of range."""
    with suppress(ValueError):
        if 0.0 < float(text) <= 600.0:
            return float(text)
    raise argparse.ArgumentTypeError(f"{text} is not a number of seconds, more than 0, up to 600")
