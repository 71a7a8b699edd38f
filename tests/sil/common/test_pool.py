# SPDX-License-Identifier: MIT
"""Tasks in processes: none is lost when another kills its process."""

import multiprocessing
import os
from collections import Counter
from typing import Any

import pytest

from sil.common import pool

FATAL = -1


def half(number: int) -> float:
    if number == FATAL:
        os._exit(9)
    return number / 2


def quick_or_endless(number: int) -> None:
    while number:
        pass


def results_of(tasks: list[int], workers: int) -> tuple[list[int], Counter[tuple[int, float]]]:
    noted: Counter[tuple[int, float]] = Counter()
    lost = pool.run(half, tasks, workers, lambda task, result: noted.update([(task, result)]))
    return lost, noted


@pytest.mark.parametrize("workers", [1, 3])
def test_every_result_is_passed_on_once(workers: int) -> None:
    lost, noted = results_of(list(range(20)), workers)
    assert lost == [] and noted == Counter((number, number / 2) for number in range(20))
    assert results_of([], workers) == ([], Counter())


@pytest.mark.parametrize("place", [0, 7, 14])
def test_a_task_that_kills_its_process_is_reported_and_costs_no_other(place: int) -> None:
    tasks = list(range(14))
    tasks.insert(place, FATAL)
    lost, noted = results_of(tasks, 2)
    assert lost == [FATAL] and noted == Counter((number, number / 2) for number in range(14))


def test_an_exception_ends_the_processes_and_is_raised() -> None:
    tasks: list[Any] = [0, "one", 2]
    with pytest.raises(TypeError):
        pool.run(half, tasks, 2, lambda task, result: None)
    assert multiprocessing.active_children() == []


def test_an_interrupted_pool_leaves_no_process_behind() -> None:
    def interrupt(task: int, result: None) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pool.run(quick_or_endless, [0, 1], 2, interrupt)
    assert multiprocessing.active_children() == []
