# SPDX-License-Identifier: MIT
"""Compares the fixed-point functions with libfixmath and the C libraries' float.

Errors and times are measured on this processor, instructions on an emulated Cortex-M4. The
arguments are in tests/core/fixed_compared.cpp and tests/core/fixed_rivals.hpp.
"""

import math
import subprocess
import sys
from typing import NamedTuple

from rich.console import Console
from rich.table import Table

from sil import ROOT
from sil.examine.metal.image import play

ARGUMENTS = 1 << 22
HERE = ROOT / "build/release/tests/fixed_compared"
THERE = ROOT / "build/cortex-m/tests/cortex_m"
_TITLES = {"sin": "sin, within ±π", "sin_far": "sin, within ±32768", "cos": "cos, within ±π"}


class MeasuredFunction(NamedTuple):
    """One function: largest errors in LSB of Q16, times in ns per call; NaN: libfixmath lacks it.

    Instructions per call on the Cortex-M4: of Q16, and of newlib's float without and with the
    processor's floating point unit.
    """

    name: str
    arguments: int
    error: float
    error_libfixmath: float
    error_float: float
    ns: float
    ns_libfixmath: float
    ns_float: float
    instructions: int
    instructions_soft: int
    instructions_fpu: int


def measure(arguments: int) -> list[MeasuredFunction]:
    """Measure every function with at least that many arguments; requires the built programs."""
    command = [str(HERE), str(arguments)]
    done = subprocess.run(command, check=True, capture_output=True, text=True)  # noqa: S603
    soft, hard = (play(b"", THERE / f"fixed_instructions_{abi}") for abi in ("soft", "hard"))
    rows = []
    for line in done.stdout.splitlines():
        name, count, *figures = line.split()
        e, e_libfixmath, e_float, ns, ns_libfixmath, ns_float = map(float, figures)
        rows.append(
            MeasuredFunction(
                *(name, int(count), e, e_libfixmath, e_float, ns, ns_libfixmath, ns_float),
                *(int(hard[f"q16.{name}"]), int(soft[f"float.{name}"]), int(hard[f"float.{name}"])),
            )
        )
    return rows


def _table(title: str, columns: tuple[str, ...], cells: dict[str, tuple[str, ...]]) -> Table:
    table = Table("", title=title, title_justify="left")
    for column in columns:
        table.add_column(column, justify="right")
    for name, figures in cells.items():
        table.add_row(_TITLES.get(name, name), *figures)
    return table


def _number(x: float, form: str) -> str:
    return "" if math.isnan(x) else format(x, form)


def tables(rows: list[MeasuredFunction]) -> list[Table]:
    """The printed tables: errors, times, instructions; one line per function."""
    return [
        _table(
            "largest error, LSB of Q16",
            ("arguments", "Q16", "libfixmath", "float"),
            {
                r.name: (
                    f"{r.arguments:,}",
                    f"{r.error:.2f}",
                    _number(r.error_libfixmath, ",.2f"),
                    f"{r.error_float:,.3f}",
                )
                for r in rows
            },
        ),
        _table(
            "time of a call here, ns",
            ("Q16", "libfixmath", "libfixmath / Q16", "float"),
            {
                r.name: (
                    f"{r.ns:.1f}",
                    _number(r.ns_libfixmath, ".1f"),
                    _number(r.ns_libfixmath / r.ns, ".1f"),
                    f"{r.ns_float:.1f}",
                )
                for r in rows
            },
        ),
        _table(
            "instructions of a call, Cortex-M4",
            ("Q16", "newlib's float", "newlib / Q16", "newlib's float with FPU"),
            {
                r.name: (
                    f"{r.instructions:,}",
                    f"{r.instructions_soft:,}",
                    f"{r.instructions_soft / r.instructions:.1f}",
                    f"{r.instructions_fpu:,}",
                )
                for r in rows
            },
        ),
    ]


def main() -> int:
    """Run the comparison; exit status 1 if an error of our functions reaches one LSB."""
    rows = measure(ARGUMENTS)
    Console().print(*tables(rows), sep="\n")
    return 0 if all(row.error < 1 for row in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
