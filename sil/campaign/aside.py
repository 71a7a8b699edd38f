# SPDX-License-Identifier: MIT
"""Work in parallel with a campaign, which never waits longer than that work takes."""

import multiprocessing
import threading
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

from sil.scenario.scenario import Scenario


class _GivenUpError(Exception):
    """The campaign has ended before its nominal run."""


@contextmanager
def nominal_run(
    out: Path, scenario: Scenario, parameters: Mapping[str, float], say: Callable[[str], object]
) -> Iterator[None]:
    """Sail the nominal run, which has no draws, and import the modules that draw pictures.

    A failure does not affect the campaign: it is only reported to `say`. If the campaign ends
    early, so does the nominal run.
    """
    given_up = threading.Event()

    def progress(_: float) -> None:
        if given_up.is_set():
            raise _GivenUpError

    def sail() -> None:
        from sil.campaign import (  # noqa: F401, PLC0415
            campaign_report,
            nominal,
            table,
        )

        try:
            nominal.write(out, scenario, dict(parameters), progress)
        except _GivenUpError:
            pass
        except Exception as error:  # whatever fails here, the campaign goes on
            say(f"no nominal run: {type(error).__name__}: {error}")

    with ThreadPoolExecutor(1) as thread:
        sailed = thread.submit(sail)
        try:
            yield
            sailed.result()
        except BaseException:
            given_up.set()
            raise


@contextmanager
def in_a_process(work: Callable[..., object], *arguments: object) -> Iterator[Callable[[], object]]:
    """Call `work` in a process of its own; the yielded function returns its result or raises."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("fork")) as process:
        yield process.submit(work, *arguments).result
