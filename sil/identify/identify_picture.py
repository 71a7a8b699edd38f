# SPDX-License-Identifier: MIT
"""The picture of an identification: logs, and their prediction by a hull fitted to the others."""

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sil.common.colours import BLACK, GREY, colour_of
from sil.identify.identification import Identification
from sil.identify.score import predicted
from sil.identify.voyage_log import SAMPLE_S, Array
from sil.identify.voyage_model import before
from sil.identify.windows import Windows, cut
from sil.report import plots

_SHOWN = 6
_ROWS = (
    ("command", None),
    ("u (m/s)", 3),
    ("v (m/s)", 4),
    ("r (rad/s)", 5),
)


def predictions(found: Identification) -> Figure:
    """Ten-second windows across all logs, measured and predicted in open loop by the last fit."""
    windows = cut(found.logs)
    windows = windows.chosen(windows.working())
    which = np.unique(np.linspace(0, len(windows) - 1, min(_SHOWN, len(windows))).astype(int))
    windows = windows.chosen(np.isin(np.arange(len(windows)), which))
    error = predicted(found.problem, found.fit.values, found.fit.local, windows)
    with matplotlib.rc_context(plots.STYLE):
        size = (2.2 * len(windows) + 0.8, 8.0)
        figure = Figure(figsize=size, layout="constrained")
        panels = figure.subplots(len(_ROWS), len(windows), squeeze=False, sharex=True, sharey="row")
        t: Array = np.arange(len(error), dtype=np.float64) * SAMPLE_S
        for column in range(len(windows)):
            name = found.logs[windows.log[column]].name
            panels[0, column].set_title(f"{name}, {windows.start_s[column]:.0f} s")
            for row, (_, channel) in enumerate(_ROWS):
                _draw(panels[row, column], t, windows, error, column, channel)
            panels[-1, column].set_xlabel("s")
        for row, (label, _) in enumerate(_ROWS):
            panels[row, 0].set_ylabel(label)
        for row in (0, 1):
            handles, labels = panels[row, 0].get_legend_handles_labels()
            panels[row, 0].legend(handles, labels, fontsize="x-small")
    return figure


def _draw(
    axes: Axes, t: Array, windows: Windows, error: Array, column: int, channel: int | None
) -> None:
    if channel is None:
        given = windows.commands[before(SAMPLE_S) :, column]
        axes.step(t, given[:, 0], color=colour_of(1), label="port")
        axes.step(t, given[:, 1], color=colour_of(2), ls="--", label="starboard")
        axes.set_ylim(-1.1, 1.1)
        return
    measured = windows.measured[:, channel, column]
    axes.plot(t, measured, color=GREY, lw=2.0, label="measured")
    axes.plot(t, measured - error[:, channel, column], color=BLACK, lw=1.0, label="predicted")
