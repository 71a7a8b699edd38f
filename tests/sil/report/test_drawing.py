# SPDX-License-Identifier: MIT
"""Pictures that a process of its own draws."""

import os
import signal

from sil.report.drawing import Drawing, draw
from tests.sil.report.test_run_report import made_up_run


def test_pictures_of_the_process_equal_those_drawn_directly() -> None:
    _, trace = made_up_run(ticks=200)
    limits_N = [(-1.0, 1.0), (-2.0, 2.0)]
    with Drawing() as drawing:
        drawing.begin("pair", trace, limits_N)
        assert drawing.pictures() == draw("pair", trace, limits_N)


def test_pictures_are_drawn_even_if_the_drawing_process_was_killed() -> None:
    _, trace = made_up_run(ticks=200)
    with Drawing() as drawing:
        drawing.begin("pair", trace, [])
        os.kill(drawing.process_id, signal.SIGKILL)
        assert drawing.pictures() == draw("pair", trace)


def test_run_that_ends_without_a_trace_leaves_no_process() -> None:
    with Drawing() as drawing:
        process_id = drawing.process_id
    assert not os.path.exists(f"/proc/{process_id}")
