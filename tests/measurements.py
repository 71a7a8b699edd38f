# SPDX-License-Identifier: MIT
"""Reads the tables of the page of measurements for tests that verify its figures."""

import math
import re
from pathlib import Path

PAGE = Path(__file__).parents[1] / "sil" / "docs" / "MEASUREMENTS.md"


def row(name: str) -> list[str]:
    """The other cells of the only row whose first cell begins with `name`."""
    lines = [line for line in PAGE.read_text(encoding="utf-8").splitlines() if line[:1] == "|"]
    cells = [[cell.strip() for cell in line.split("|")[1:-1]] for line in lines]
    found = [others for first, *others in cells if re.match(rf"{re.escape(name)}\b", first)]
    assert len(found) == 1, f"{PAGE.name} has {len(found)} rows of '{name}'"
    return found[0]


def printed(figure: float, cell: str) -> str:
    """The figure with as many decimals as `cell` has; empty for NaN."""
    decimals = len(cell.partition(".")[2])
    return "" if math.isnan(figure) else f"{figure:,.{decimals}f}"


def numbers(text: str) -> list[float]:
    """The numbers in a cell."""
    return [float(number.replace(",", "")) for number in re.findall(r"\d[\d,]*(?:\.\d+)?", text)]
