# SPDX-License-Identifier: MIT
"""Tasks in local processes; a task that kills its process is reported and affects no other."""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import forkserver
from typing import TypeVar

Task = TypeVar("Task")
Result = TypeVar("Result")


def prepare(modules: Sequence[str]) -> None:
    """Begin to import the modules that the workers need, in a separate process.

    The workers are forked from that process because, unlike this one, it has no threads.
    """
    # In a wheel, importing the first module makes the others importable in that process.
    multiprocessing.set_forkserver_preload(["flotilla_usv", *modules])
    # That process inherits ignored signals: only this one handles Ctrl-C.
    handler = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        forkserver.ensure_running()
    finally:
        signal.signal(signal.SIGINT, handler)


def run(
    function: Callable[[Task], Result],
    tasks: Sequence[Task],
    workers: int,
    note: Callable[[Task, Result], None],
) -> list[Task]:
    """Run `function` on each task in `workers` processes; calls `note` with each result.

    Returns the tasks that killed their process twice: beside others, then alone. An exception of
    `function` or `note`, or an interrupt, ends the processes and is raised.
    """
    suspects: list[Task] = []
    waiting = deque(tasks)
    while waiting:
        suspects += _until_broken(function, waiting, workers, note)
    lost = []
    for task in suspects:
        lost += _until_broken(function, deque([task]), 1, note)
    return lost


def _until_broken(
    function: Callable[[Task], Result],
    waiting: deque[Task],
    workers: int,
    note: Callable[[Task, Result], None],
) -> list[Task]:
    """Run tasks from `waiting` until all are done or a process dies; return those in flight."""
    context = multiprocessing.get_context("forkserver")
    others = multiprocessing.active_children()
    futures: dict[Future[Result], Task] = {}
    with ProcessPoolExecutor(workers, context, _begin) as pool:
        try:
            while waiting or futures:
                # limits the tasks that are in flight when a process dies
                while waiting and len(futures) < 2 * workers:
                    futures[pool.submit(function, waiting[0])] = waiting[0]
                    waiting.popleft()
                for future in wait(futures, return_when=FIRST_COMPLETED).done:
                    result = future.result()
                    note(futures.pop(future), result)
        except BrokenProcessPool:
            return list(futures.values())
        except BaseException:
            for future in futures:
                future.cancel()
            for process in multiprocessing.active_children():
                if process not in others:
                    process.terminate()
            raise
    return []


def _begin() -> None:
    """Initialise a worker: it leaves Ctrl-C to the parent, and dies with the parent."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def follow() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=follow, daemon=True).start()
