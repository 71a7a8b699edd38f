# SPDX-License-Identifier: MIT
"""The progress of a campaign, in the terminal."""

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

from sil.scenario.scenario import Scenario


@contextmanager
def bar(
    nominal: Scenario, runs: int, done: int, console: Console
) -> Iterator[Callable[[int], None]]:
    """Show how many of `runs` runs are sailed, how fast, and the time left.

    `done` are there at the beginning; what it gives is called with the number of those that come.
    """
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.fields[rate]}"))
    shown = Progress(
        TextColumn(f"{nominal.name}: runs"), *columns, TimeRemainingColumn(), console=console
    )
    began_s = time.perf_counter()
    with shown:
        task = shown.add_task("", total=runs, completed=done, rate="")

        def advance(more: int) -> None:
            shown.advance(task, more)
            sailed_s = (shown.tasks[0].completed - done) * len(nominal.boat) * nominal.duration_s
            rate = sailed_s / (time.perf_counter() - began_s)
            shown.update(task, rate=f"{rate:,.0f} boat-seconds/s")

        yield advance
