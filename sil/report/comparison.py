# SPDX-License-Identifier: MIT
"""Picture of a scenario sailed with two laws: a map, and the boats' distances from their slots."""

import io
from collections.abc import Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from PIL import Image

from sil.common.colours import BLACK, COLOURS, FAINT, GREY, colour_of
from sil.lockstep import metrics
from sil.plant.hull import Array
from sil.report import plots
from sil.report.figures import Trace

_LEAST_M = 1e-5
# the title leaves room for the times above the boats
_STYLE: dict[Any, Any] = {"figure.dpi": 130, "font.size": 9.5, "axes.titlepad": 14.0}
_ABOVE: dict[str, Any] = {
    "loc": "lower right",
    "bbox_to_anchor": (1.0, 1.0),
    "ncols": 2,
    "borderaxespad": 0.1,
}
_BASELINE: dict[str, Any] = {"lw": 0.9, "ls": (0, (3, 2)), "alpha": 0.55}


def picture(
    name: str, limit_m: float, map_s: float, baseline: Sequence[Trace], product: Sequence[Trace]
) -> Figure:
    """Map of the first run of the product's law, distances of both laws' runs.

    With one run for each law, each boat has a line. With more, the picture shows the median and 5
    to 95 % of the worst boat's distance. Traces have t_s (T), eta (T, N+1, 3) and error (T, N, 3),
    the same times in all; `baseline` may be empty.
    """
    t_s, eta = product[0]["t_s"], product[0]["eta"]
    shown = max(2, int(np.searchsorted(t_s, t_s[0] + map_s, side="right")))
    with matplotlib.rc_context({**plots.STYLE, **_STYLE}):
        figure = Figure(figsize=(10.0, 4.1), layout="constrained")
        chart, over_time = figure.subplots(1, 2, width_ratios=(1.0, 1.15))
        part = "the whole run" if shown == t_s.size else f"the first {map_s:g} s"
        chart.set_title(f"{name}: {part}, product")
        plots.draw_map(chart, t_s[:shown], eta[:shown], formations=4, hull_share=1.0 / 28.0)
        many = f", worst boat, {len(product)} seeds: median, 5–95 %" if len(product) > 1 else ""
        over_time.set(title="distance from the slot", xlabel="time since release (s)")
        over_time.set(ylabel=f"|e| (m){many}", yscale="log", xlim=(t_s[0], t_s[-1]))
        laws = _draw_envelopes if len(product) > 1 else _draw_boats
        laws(over_time, baseline, product)
        _draw_limit(over_time, t_s, limit_m)
        low = np.quantile(np.nan_to_num([_distances(trace) for trace in product]), 0.01)
        over_time.set_ylim(bottom=max(_LEAST_M, min(0.5 * limit_m, low)))
        handles, labels = chart.get_legend_handles_labels()
        if eta.shape[1] - 1 > len(COLOURS):
            # colours repeat, so they do not identify boats
            handles, labels = [handles[0], handles[-1]], [labels[0], labels[-1]]
        figure.legend(handles, labels, loc="outside lower center", ncols=min(len(labels), 9))
    return figure


def _draw_boats(axes: Axes, baseline: Sequence[Trace], product: Sequence[Trace]) -> None:
    for trace in baseline:
        for boat, distance in enumerate(_distances(trace).T, start=1):
            axes.plot(trace["t_s"], distance, color=colour_of(boat), **_BASELINE)
    for trace in product:
        for boat, distance in enumerate(_distances(trace).T, start=1):
            axes.plot(trace["t_s"], distance, color=colour_of(boat), lw=1.3)
    handles = [
        Line2D([], [], color=GREY, **_BASELINE),
        Line2D([], [], color=GREY, lw=1.3),
    ]
    axes.legend(handles, ["paper", "product"], **_ABOVE)


def _draw_envelopes(axes: Axes, baseline: Sequence[Trace], product: Sequence[Trace]) -> None:
    for law, runs, colour in (
        ("paper", baseline, GREY),
        ("product", product, COLOURS[0]),
    ):
        if not runs:
            continue
        worst = np.array([_distances(trace).max(axis=1) for trace in runs])
        low, median, high = np.percentile(worst, [5, 50, 95], axis=0)
        t_s = runs[0]["t_s"]
        axes.fill_between(t_s, low, high, color=colour, alpha=0.25, lw=0)
        axes.plot(t_s, median, color=colour, label=law)
    axes.legend(**_ABOVE)


def _draw_limit(axes: Axes, t_s: Array, limit_m: float) -> None:
    if not np.isfinite(limit_m):
        return
    axes.axhline(limit_m, color=BLACK, lw=1.0, ls=plots.DASHED)
    by_level = axes.get_yaxis_transform()
    text = axes.text(0.01, limit_m * 0.9, f"{limit_m:g} m", va="top", transform=by_level)
    text.set_path_effects([plots.HALO])
    third = t_s[0] + (t_s[-1] - t_s[0]) * 2.0 / 3.0
    axes.axvspan(third, t_s[-1], color=FAINT, zorder=0)
    by_time = axes.get_xaxis_transform()
    text = axes.text(third, 0.97, " last third: RMS", va="top", transform=by_time)
    text.set(color=GREY, path_effects=[plots.HALO])


def _distances(trace: Trace) -> Array:
    # the logarithm of zero does not exist
    return np.maximum(metrics.distances(trace["error"]), 0.1 * _LEAST_M)


def png(figure: Figure) -> bytes:
    """The figure as a PNG file of 256 colours, a third as large as one of all colours."""
    canvas: Any = FigureCanvasAgg(figure)  # which has no types
    canvas.draw()
    pixels = np.asarray(canvas.buffer_rgba())[..., :3]
    reduced = Image.fromarray(pixels.copy()).quantize(256, dither=Image.Dither.NONE)
    content = io.BytesIO()
    reduced.save(content, format="png")
    return content.getvalue()
