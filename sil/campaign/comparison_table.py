# SPDX-License-Identifier: MIT
"""Table of two campaigns side by side, for the terminal."""

import math
from collections.abc import Mapping

from rich import box
from rich.table import Table

from sil.campaign.campaign_figures import WHAT
from sil.campaign.change import FALSE_ALARMS, MARGIN, Change, confidence

_STYLES = {"worse": "bold red", "better": "bold green", "same": None}


def table(found: Mapping[str, Change]) -> Table:
    """One row for each figure: A, B, their ratio with its interval, and the verdict."""
    grid = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    grid.add_column("")
    for column in ("A", "B", "B/A", f"{confidence(len(WHAT)):.2%} interval"):
        grid.add_column(column, justify="right", no_wrap=True)
    grid.add_column("", no_wrap=True)
    for key, one in found.items():
        verdict = "" if one.verdict == "same" else one.verdict
        grid.add_row(WHAT[key], *_cells(one), verdict, style=_STYLES[one.verdict])
    return grid


def note(*, paired: bool) -> str:
    """Explain the table's numbers."""
    own = "; B/A is the median of the runs' own ratios" if paired else ""
    return (
        f"Medians over the runs unless stated otherwise{own}. Better, worse: all of the "
        f"interval is more than {MARGIN:.0%} away from 1. Of comparisons of equal code at most "
        f"{FALSE_ALARMS:.0%} report any change."
    )


def _cells(one: Change) -> list[str]:
    if math.isnan(one.p):
        ratios = [_number(one.ratio), f"{_number(one.low)} … {_number(one.high)}"]
        return [_number(one.a), _number(one.b), *ratios]
    return [f"{one.a:.1%}", f"{one.b:.1%}", "", f"p = {one.p:.2g}"]


def _number(value: float) -> str:
    return "∞" if math.isinf(value) else f"{value:.3f}"
