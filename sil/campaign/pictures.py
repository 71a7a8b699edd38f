# SPDX-License-Identifier: MIT
"""Pictures of a campaign, after the paper's Figs. 1 and 2; paths: `sil.report.plots.formation`."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

from sil.campaign.finished import Columns
from sil.campaign.samples import Samples
from sil.common.colours import BLACK, GREY, colour_of
from sil.lockstep import metrics
from sil.plant.hull import Array
from sil.report import plots

MOST_BOATS = 6
_LEAST_M, _NOMINAL_M = 1e-5, 1e-3
_BANDS = (("p5", "p95", 0.28, "5–95 % of the runs"), ("p25", "p75", 0.45, "25–75 %"))
_NOMINAL: dict[str, Any] = {"color": BLACK, "lw": 1.0, "ls": (0, (6, 2, 1.2, 2))}
_ALL: dict[str, Any] = {"alpha": 0.11, "lw": 0}


@dataclass(frozen=True)
class Errors:
    """The data of the picture of errors: envelopes.parquet, samples, nominal.npz if any."""

    envelopes: Columns
    samples: Samples
    nominal: dict[str, Array] | None


def errors(name: str, shown: Errors, pairs: Sequence[str]) -> Figure:
    """Envelopes of each boat's distance from its slot over all runs, logarithmic, one panel a boat.

    `pairs`: the title of each boat's panel. If a percentile is infinite because runs diverged, its
    band ends at the top. If there are more than six boats, the worst six at the end of the run are
    shown.
    """
    boats = _worst_boats(shown.envelopes, len(pairs))
    across = min(2, len(boats))
    down = math.ceil(len(boats) / across)
    with matplotlib.rc_context({**plots.STYLE, "axes.titlesize": 10.5}):
        figure = Figure(figsize=(8.0, 1.3 + 2.35 * down), layout="constrained")
        panels = figure.subplots(down, across, sharex=True, sharey=True, squeeze=False)
        bottom, top = _limits(shown)
        panels[0, 0].set(yscale="log", ylim=(bottom, top))
        plots.plain_decades(panels[0, 0])
        for axes, boat in zip(panels.flat, boats, strict=False):
            axes.set_title(pairs[boat - 1])
            _draw(axes, shown, boat, (bottom, top))
        for axes in panels.flat[len(boats) :]:
            axes.set_axis_off()
        count, lost = shown.envelopes["n"].max(), shown.envelopes["n_diverged"].max()
        title = f"{name}: {count} run{'' if count == 1 else 's'}, {lost or 'none'} diverged"
        figure.suptitle(title, x=0.02, ha="left", fontsize=12)
        infinite = "\ndiverged runs: infinite" if lost else ""
        for axes in panels[:, 0]:
            axes.set_ylabel(f"formation error |e| (m){infinite}")
        for axes in panels[-1]:
            axes.set_xlabel("time since release (s)")
        handles = _legend(shown, bool(lost))
        figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def _draw(axes: Axes, shown: Errors, boat: int, limits: tuple[float, float]) -> None:
    row = shown.envelopes["boat"] == boat
    band = {key: np.clip(values[row], *limits) for key, values in shown.envelopes.items()}
    t_s, colour = shown.envelopes["t_s"][row], colour_of(boat)
    ok = shown.samples.error_m[boat - 1, shown.samples.ok]
    if ok.size:
        low, high = (np.clip(edge, *limits) for edge in (ok.min(axis=0), ok.max(axis=0)))
        axes.fill_between(shown.samples.t_s, low, high, color=colour, **_ALL)
    for low_key, high_key, alpha, _ in _BANDS:
        axes.fill_between(t_s, band[low_key], band[high_key], color=colour, alpha=alpha, lw=0)
    # without clipping, the frame does not hide a median at the top
    axes.plot(t_s, band["p50"], color=colour, lw=1.6, clip_on=False)
    if shown.nominal is not None:
        distance = metrics.distances(shown.nominal["error"][:, boat - 1])
        axes.plot(shown.nominal["t_s"], np.maximum(distance, 0.1 * limits[0]), **_NOMINAL)
    axes.axhline(metrics.SETTLED_M, color=GREY, lw=0.8, ls=(0, (1, 2)))
    # a run of less than a second has one sample
    axes.set_xlim(t_s[0], max(t_s[-1], t_s[0] + 1.0))
    _tell_infinite(axes, {key: values[row] for key, values in shown.envelopes.items()})


def _tell_infinite(axes: Axes, band: Columns) -> None:
    """Print the number of runs that the picture lacks because they are infinitely far away."""
    lost, count = int(band["n_diverged"].max()), int(band["n"].max())
    if lost:
        text = f"{lost} of {count} infinite"
        place = axes.text(0.98, 0.93, text, ha="right", va="top", transform=axes.transAxes)
        place.set(fontsize=9, color=BLACK, path_effects=[plots.HALO])


def _worst_boats(envelopes: Columns, count: int) -> list[int]:
    boats = range(1, count + 1)
    last = envelopes["t_s"] == envelopes["t_s"].max()
    end = {boat: envelopes["p95"][last & (envelopes["boat"] == boat)][0] for boat in boats}
    return sorted(sorted(boats, key=lambda boat: -end[boat])[:MOST_BOATS])


def _limits(shown: Errors) -> tuple[float, float]:
    """Bottom and top of the axis: the range of all finite numbers shown, with a margin above."""
    parts = [shown.envelopes[key] for key in ("p5", "p50", "p95")]
    parts.append(shown.samples.error_m[:, shown.samples.ok].max(axis=1, initial=0.0).ravel())
    values = np.concatenate([np.ravel(part) for part in parts])
    values = values[np.isfinite(values) & (values > 0.0)]
    if values.size == 0:
        return _LEAST_M, 1.0
    bottom = 0.7 * min(metrics.SETTLED_M, float(np.quantile(values, 0.002)))
    bottom = max(_LEAST_M, bottom)
    if shown.nominal is not None:
        least = metrics.distances(shown.nominal["error"]).min()
        bottom = min(bottom, max(_NOMINAL_M, float(least)))
    return bottom, max(1.6 * float(values.max()), 10.0 * bottom)


def _legend(shown: Errors, lost: bool) -> list[Line2D | Patch]:
    colour = GREY
    that = "all runs that did not diverge" if lost else "all runs"
    entries: list[Line2D | Patch] = [Line2D([], [], color=colour, lw=1.6, label="median")]
    entries += [
        Patch(color=colour, alpha=a, lw=0, label=label) for *_, a, label in reversed(_BANDS)
    ]
    entries.append(Patch(color=colour, label=that, **_ALL))
    if shown.nominal is not None:
        label = "nominal run: hulls as known, w = 0"
        entries.append(Line2D([], [], label=label, **_NOMINAL))
    label = f"settled: {metrics.SETTLED_M} m"
    entries.append(Line2D([], [], color=colour, lw=0.8, ls=(0, (1, 2)), label=label))
    return entries
