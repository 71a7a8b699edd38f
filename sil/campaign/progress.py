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
    """Show the number of runs sailed out of `runs`, the speed, and the time left.

    `done` runs exist at the beginning. Call the yielded function with the number of each batch's
    runs.
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
