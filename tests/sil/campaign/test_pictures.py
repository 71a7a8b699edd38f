# SPDX-License-Identifier: MIT
"""The drawn envelopes: infinite values end at the top and are mentioned."""

import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure

from sil.campaign import finished, pictures, samples
from tests.sil.campaign.made_up import Made
from tests.turns import some


def picture_of(made: Made, folder: Path) -> Figure:
    made.write(folder)
    sampled = samples.read(finished.read(folder))
    shown = pictures.Errors(finished.columns(folder, "envelopes"), sampled, None)
    return pictures.errors("made_up", shown, [f"boat {i}" for i in range(1, made.boats + 1)])


def bands(axes: Axes) -> list[tuple[float, float]]:
    """Least and greatest |e| of each shaded band: of all runs, 5–95 %, 25–75 %."""
    drawn = [c for c in axes.collections if isinstance(c, PolyCollection)]
    return [
        (y.min(), y.max()) for y in (np.asarray(c.get_paths()[0].vertices)[:, 1] for c in drawn)
    ]


def test_band_of_a_percentile_that_is_infinite_ends_at_the_top(tmp_path: Path) -> None:
    figure = picture_of(Made(runs=50, diverged=(1, 2, 3, 4)), tmp_path)
    for axes in some(figure.axes):
        top = axes.get_ylim()[1]
        ok, wide, narrow = bands(axes)
        assert wide[1] == top
        assert ok[1] < top and narrow[1] < top
        assert "4 of 50 infinite" in [text.get_text() for text in axes.texts]
    assert "50 runs, 4 diverged" in figure.get_suptitle()
    assert "diverged runs: infinite" in figure.axes[0].get_ylabel()


def test_picture_mentions_no_infinity_where_no_run_diverged(tmp_path: Path) -> None:
    figure = picture_of(Made(runs=50), tmp_path)
    for axes in some(figure.axes):
        assert not axes.texts and all(high < axes.get_ylim()[1] for _, high in some(bands(axes)))
    assert "none diverged" in figure.get_suptitle()


def test_bands_are_nested_and_the_outermost_contains_every_run(tmp_path: Path) -> None:
    axes = picture_of(Made(runs=50), tmp_path).axes[0]
    (low, high), wide, narrow = bands(axes)
    assert low <= wide[0] <= narrow[0] and narrow[1] <= wide[1] <= high
    table = finished.columns(tmp_path, "seconds")
    assert high == pytest.approx(table["error_m"][table["boat"] == 1].max())


def test_of_a_large_fleet_the_worst_boats_at_the_end_are_shown(tmp_path: Path) -> None:
    made = Made(runs=3, boats=9)
    titles = [axes.get_title(loc="left") for axes in picture_of(made, tmp_path).axes]
    table = finished.columns(tmp_path, "envelopes")
    end = table["p95"][table["t_s"] == table["t_s"].max()]
    assert titles == [f"boat {i + 1}" for i in sorted(np.argsort(-end)[:6])]


def test_a_run_of_half_a_second_has_a_picture_and_no_warning(tmp_path: Path) -> None:
    Made(runs=3).write(tmp_path)
    sampled = samples.read(finished.read(tmp_path))
    first = replace(sampled, t_s=sampled.t_s[:1], error_m=sampled.error_m[:, :, :1])
    table = finished.columns(tmp_path, "envelopes")
    envelopes = {key: values[table["t_s"] == 0.0] for key, values in table.items()}
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        pictures.errors("made_up", pictures.Errors(envelopes, first, None), list("abcd"))
