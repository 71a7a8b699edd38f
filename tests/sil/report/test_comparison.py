# SPDX-License-Identifier: MIT
"""Pictures of made-up runs, checked by their axes' content."""

import io

import numpy as np
import pytest
from PIL import Image

from sil.plant.hull import Array
from sil.report import comparison
from sil.report.figures import Trace
from tests.each_push import few


def made_up(boats: int, factor: float = 1.0) -> Trace:
    t_s: Array = np.arange(0.0, 300.1, 0.2)
    ahead = factor * np.exp(-t_s / 30.0)[:, np.newaxis] * np.arange(1.0, boats + 1)
    error = np.stack([ahead, 0.0 * ahead, 0.0 * ahead], axis=-1)
    eta = np.zeros((t_s.size, boats + 1, 3))
    eta[..., 1] = 0.5 * t_s[:, np.newaxis]
    eta[:, 1:, 0] = ahead
    return {"t_s": t_s, "eta": eta, "error": error}


@pytest.mark.parametrize("boats", [1, 4, 7])
def test_both_laws_have_a_line_a_boat_and_the_limit_is_drawn(boats: int) -> None:
    figure = comparison.picture("pair", 0.07, 60.0, [made_up(boats, 3.0)], [made_up(boats)])
    chart, over_time = figure.axes
    assert len(over_time.lines) == 2 * boats + 1
    assert list(np.asarray(over_time.lines[-1].get_ydata())) == [0.07, 0.07]
    assert chart.get_title(loc="left") == "pair: the first 60 s, product"
    assert np.asarray(chart.lines[0].get_xdata())[-1] == pytest.approx(30.0)
    colours = {line.get_color() for line in over_time.lines[:-1]}
    assert len(colours) == boats


def test_many_seeds_are_the_median_of_the_worst_boat_and_its_envelope() -> None:
    runs = [made_up(2, factor) for factor in (1.0, 2.0, 9.0)]
    over_time = comparison.picture("pair", 0.1, 300.0, runs[:2], runs).axes[1]
    first = [np.asarray(line.get_ydata())[0] for line in over_time.lines[:2]]
    assert first == pytest.approx([3.0, 4.0])
    assert len(over_time.collections) == 2
    assert "worst boat, 3 seeds" in over_time.get_ylabel()


@pytest.mark.parametrize("baseline", [[], [made_up(4, 1e9)], [made_up(4, 0.0)]])
def test_picture_is_small_whatever_the_baseline_did(baseline: list[Trace]) -> None:
    picture = comparison.png(comparison.picture("pair", 0.01, 60.0, baseline, [made_up(4)]))
    assert len(picture) < 150_000
    with Image.open(io.BytesIO(picture)) as image:
        assert (image.format, image.width) == ("PNG", 1300)


@pytest.mark.parametrize("seeds", few([1, 3], [1]))
@pytest.mark.parametrize("wrong", [1e30, np.nan])
def test_boats_with_nan_positions_can_be_drawn(wrong: float, seeds: int) -> None:
    lost = {name: values.copy() for name, values in made_up(4).items()}
    for name in ("eta", "error"):
        lost[name][200:] *= wrong
    assert comparison.png(comparison.picture("pair", 0.1, 300.0, [lost] * seeds, [lost] * seeds))
