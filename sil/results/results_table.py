# SPDX-License-Identifier: MIT
"""The table of results: figures, bounds, and whether they were met."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from rich import box
from rich.table import Table

from sil.results.claims import BASELINE, CLAIMS, PRODUCT, Bound
from sil.results.sailing import Outcome

COLUMNS = ("scenario", "", "paper", "product", "to reach", "")
_WORDS, _NUMBERS = 1, (2, 3, 4)
BEGIN, END = "<!-- results: made by flotilla results -->\n", "<!-- end -->"
PERCENTILE = 0.95


@dataclass(frozen=True)
class PublishedBound:
    """A bound of a scenario and the two laws' figures.

    A figure is infinite if never reached, None if a run failed, NaN if the bound needs none.
    `seeds`: number of runs; a law's figure is the 95th percentile over them.
    """

    scenario: str
    bound: Bound
    baseline: float | None
    product: float | None
    seeds: int

    @property
    def reached(self) -> bool:
        """Whether the runs meet the bound; a failed run does not."""
        if self.baseline is None or self.product is None:
            return False
        return self.bound.reached(self.baseline, self.product)

    @property
    def cells(self) -> list[str]:
        """The cells of its row; `COLUMNS` are their heads."""
        claim, bound = CLAIMS[self.scenario], self.bound
        first = bound.key == claim.bounds[0].key
        seeds = f"; 95th percentile of {self.seeds} seeds" if claim.many_seeds else ""
        return [
            self.scenario if first else "",
            claim.about + seeds if first else bound.what,
            told(self.baseline, bound, BASELINE),
            told(self.product, bound, PRODUCT),
            bound.to_reach or "–",
            ("yes" if self.reached else "NO") if bound.to_reach else "",
        ]


def rows(outcomes: Sequence[Outcome]) -> list[PublishedBound]:
    """The table's rows for the scenarios in `outcomes`, in their order."""
    found = []
    for name in dict.fromkeys(outcome.job.scenario for outcome in outcomes):
        laws = {
            law: [o for o in outcomes if (o.job.scenario, o.job.law) == (name, law)]
            for law in (BASELINE, PRODUCT)
        }
        for bound in CLAIMS[name].bounds:
            baseline, product = (percentile(runs, bound, law) for law, runs in laws.items())
            found.append(PublishedBound(name, bound, baseline, product, len(laws[PRODUCT])))
    return found


def for_terminal(table: Sequence[PublishedBound]) -> Table:
    """The table for the terminal; missed bounds are red."""
    grid = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for place, column in enumerate(COLUMNS):
        # only the text columns may wrap
        grid.add_column(
            column, justify="right" if place in _NUMBERS else "left", no_wrap=place != _WORDS
        )
    for row in table:
        grid.add_row(*row.cells, style=None if row.reached else "bold red")
    return grid


def for_page(table: Sequence[PublishedBound]) -> str:
    """The table in Markdown, and a picture for each scenario."""
    lines = [f"| {' | '.join(COLUMNS)} |", "|---|---|--:|--:|--:|---|"]
    for row in table:
        name, *others, reached = row.cells
        link = f"[`{name}`](../scenarios/{name}.toml)" if name else ""
        lines.append(f"| {' | '.join([link, *others, reached.replace('NO', '**NO**')])} |")
    for name in dict.fromkeys(row.scenario for row in table):
        lines += ["", f"![`{name}`: map, and distances from the slot](../results/{name}.png)"]
    return "\n".join(lines)


def between(text: str, begin: str, content: str) -> str:
    """Replace the page's text from the mark `begin` to `END`; ValueError if a mark is missing."""
    before, middle, rest = text.partition(begin)
    _, end, after = rest.partition(END)
    if not (middle and end) or begin in after:
        raise ValueError(f"no place for the results: no pair {begin.strip()} … {END}")
    return f"{before}{begin}{content}\n{END}{after}"


def percentile(
    runs: Sequence[Outcome], bound: Bound, law: str, share: float = PERCENTILE
) -> float | None:
    """The figure that `share` of the runs do not exceed, rounded up to a run.

    None: a run failed, NaN: no bound for this law.
    """
    if law not in bound.laws:
        return math.nan
    if not runs or any(run.failure for run in runs):
        return None
    return _figure(decisive(runs, bound, share), bound)


def decisive(runs: Sequence[Outcome], bound: Bound, share: float = PERCENTILE) -> Outcome:
    """The run whose figure `percentile` gives; none of `runs` failed."""
    ordered = sorted(runs, key=lambda run: _figure(run, bound))
    return ordered[math.ceil(share * (len(ordered) - 1))]


def _figure(run: Outcome, bound: Bound) -> float:
    # NaN, from a boat that diverged, is the worst
    figure = run.figures[bound.key]
    return math.inf if math.isnan(figure) else figure


def told(figure: float | None, bound: Bound, law: str) -> str:
    """A law's figure, formatted for the pages."""
    if law not in bound.laws:
        return "–"
    if figure is None:
        return "failed"
    if not math.isfinite(figure):
        return "never"
    number = f"{figure:.0f}" if bound.unit == "boats" else _short(figure)
    return f"{number} {bound.unit}"


def _short(figure: float) -> str:
    """Three digits, or two of a small number."""
    if figure < 0.0001:
        return "< 0.0001"
    return f"{figure:#.2g}" if figure < 0.1 else f"{figure:#.3g}".rstrip(".")
