# SPDX-License-Identifier: MIT
"""Command-line options that several commands share."""

import argparse
import difflib
import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from sil.scenario.law import LAWS


def add_to(command: argparse.ArgumentParser, out: str) -> None:
    """Add a scenario and its overrides; `out` describes the folder of the results."""
    command.add_argument("scenario", help="a name in sil/scenarios, or the path of a .toml file")
    command.add_argument("--out", type=nonempty_path, metavar="DIR", help=out)
    command.add_argument(
        "--seed", type=int, metavar="N", help="seed of every random number (the scenario's)"
    )
    command.add_argument(
        "--law",
        choices=LAWS,
        help="override the law; discards the scenario's LAW_* gains except LAW_KDU and LAW_KDR",
    )
    command.add_argument(
        "--param",
        action="append",
        default=[],
        metavar="NAME=VALUE",
        help="set a firmware parameter of every boat; repeatable",
    )
    command.add_argument(
        "--set",
        action="append",
        default=[],
        metavar="KEY=VALUE",
        help="set a key: link.delay_s=0.1 or boat.2.eta=[0,0,0]; repeatable",
    )


def add_workers_to(command: argparse.ArgumentParser) -> None:
    """Add the option for the number of parallel processes."""
    command.add_argument(
        "--workers",
        type=count,
        default=os.cpu_count(),
        metavar="N",
        help="number of parallel processes (number of CPUs)",
    )


def nonempty_path(text: str) -> Path:
    """Parse a path; an empty one, as of an unset variable of the shell, is not this folder."""
    if text:
        return Path(text)
    raise argparse.ArgumentTypeError("it is empty; name a folder")


def count(text: str) -> int:
    """Parse a count of at least 1."""
    with suppress(ValueError):
        if int(text) >= 1:
            return int(text)
    raise argparse.ArgumentTypeError(f"{text} is not a whole number of at least 1")


def number(text: str) -> int:
    """Parse a number of 0 or more."""
    with suppress(ValueError):
        if int(text) >= 0:
            return int(text)
    raise argparse.ArgumentTypeError(f"{text} is not a whole number of at least 0")


def parameters_of(texts: list[str]) -> dict[str, float]:
    """Parameters from `NAME=VALUE` texts; ValueError names an invalid or unknown one."""
    values = {}
    for text in texts:
        name, _, value = text.partition("=")
        try:
            values[name.strip()] = float(value)
        except ValueError:
            raise ValueError(f'--param "{text}": must be NAME=VALUE, VALUE a number') from None
    if values:
        _check_names(values)
    return values


def _check_names(given: Iterable[str]) -> None:
    import flotilla  # noqa: PLC0415 imported only if there are parameters to check

    names = [parameter["name"] for parameter in flotilla.parameter_list()]
    for name in given:
        if name not in names:
            near = difflib.get_close_matches(name, names, 1, 0.4)
            hint = f'; did you mean "{near[0]}"?' if near else ""
            raise ValueError(f"--param: unknown parameter {name}{hint}")
