# SPDX-License-Identifier: MIT
"""Columns that were smoothed, shifted or repeated are reported; a plain log has nothing odd."""

from dataclasses import replace

import numpy as np
import pytest

from sil.identify import oddities
from sil.identify.voyage_log import Array, VoyageLog
from tests.sil.identify.sailed import levels, sail

U, R = 3, 5


def plain(seed: int) -> VoyageLog:
    rng = np.random.default_rng(seed)
    return sail(levels(rng, 200.0), rng)


def changed(log: VoyageLog, column: int, series: Array) -> VoyageLog:
    motion = log.motion.copy()
    motion[:, column] = series
    return replace(log, motion=motion)


@pytest.mark.parametrize("seed", range(5))
def test_a_plain_log_has_nothing_odd(seed: int) -> None:
    assert oddities.of_logs([plain(seed)]) == []


def test_smoothing_from_both_sides_is_found_and_called_acausal() -> None:
    log = plain(1)
    window = np.hanning(21)[1:-1]
    smooth = np.convolve(log.motion[:, U], window / window.sum(), mode="same")
    told = oddities.of_logs([changed(log, U, smooth)])
    assert any("surge look" in line for line in told)
    assert any("surge answers commands" in line and "acausal" in line for line in told)


@pytest.mark.parametrize("samples", [-2, 1, 2])
def test_the_time_shift_of_a_yaw_rate_column_is_measured(samples: int) -> None:
    log = plain(2)
    late = changed(log, R, np.roll(log.motion[:, R], samples))
    assert oddities.yaw_rate_age([late]) == pytest.approx(0.1 * samples, abs=0.03)
    word = "later" if samples > 0 else "earlier"
    assert any(f"s {word} than the heading" in line for line in oddities.of_logs([late]))


def test_a_repeated_position_is_reported() -> None:
    told = oddities.of_logs([replace(plain(3), fresh=0.5)])
    assert told == [
        "the position is new in only 50% of the samples: it comes at about 5 Hz and is repeated"
    ]
