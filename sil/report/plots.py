# SPDX-License-Identifier: MIT
"""Pictures of a run, drawn from the trace (arrays as in trace.npz, see `sil.lockstep.metrics`)."""

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib
import numpy as np
from matplotlib import patheffects
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullLocator

from sil.common.colours import BAD, BLACK, COLOURS, FAINT, GREY, colour_of
from sil.lockstep import metrics
from sil.plant.hull import Array

_WIDTH_IN = 8.0
_SHOWN_SAMPLES = 3000
_FARTHEST_M = 1e6
_LEAST_M, _MOST_LEAST_M = 1e-5, 1e-3  # limits for the lower end of the axis of errors
_LEGEND_COLUMNS = 6
_AT_LIMIT = 1e-3  # share of the range between the limits
VIRTUAL_LEADER = "virtual leader"
DASHED = (0, (4, 3))
HALO = patheffects.withStroke(linewidth=3, foreground="white")
# outline of a hull of length 1, body axes: forward, starboard
_OUTLINE = np.array([[0.5, 0.0], [0.2, 0.17], [-0.5, 0.14], [-0.5, -0.14], [0.2, -0.17]])
STYLE: dict[Any, Any] = {
    "figure.dpi": 200,
    "font.size": 10.5,
    "axes.titlesize": 12,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": GREY,
    "axes.labelcolor": GREY,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#eaeaea",
    "xtick.color": GREY,
    "ytick.color": GREY,
    "lines.linewidth": 1.3,
    "legend.frameon": False,
}


def formation(name: str, trace: Mapping[str, Array], root: str = VIRTUAL_LEADER) -> Figure:
    """Paths, north up and east right, with the formation at evenly spaced times.

    `root`: the name of agent 0.

    One map shows the first fifth of the run, in which the formation closes up, another the whole
    run. If an agent's state stops being finite, the maps end there.
    """
    count = _drawable(trace["eta"])
    t_s, eta = trace["t_s"][:count], trace["eta"][:count]
    first = min(max(2, count // 5), count)
    whole = "the whole run"
    if count < trace["t_s"].size:
        whole = f"up to {t_s[-1]:.2f} s; after that an agent's values are not finite"
    windows = {f"{name}: the first {t_s[first - 1]:.0f} s": first, whole: count}
    shapes = [_height_to_width(eta[:end]) for end in windows.values()]
    with matplotlib.rc_context(STYLE):
        rows = -(-(eta.shape[1] + 1) // _LEGEND_COLUMNS)
        height_in = _WIDTH_IN * sum(shapes) + 2.0 + 0.25 * rows
        figure = Figure(figsize=(_WIDTH_IN, height_in))
        _lay_out(figure, height_in, between=2.0 / (_WIDTH_IN * sum(shapes)), rows=rows)
        maps = figure.subplots(2, 1, height_ratios=shapes)
        for axes, (title, end) in zip(maps, windows.items(), strict=True):
            axes.set_title(title)
            draw_map(axes, t_s[:end], eta[:end], formations=6, hull_share=1.0 / 45.0, root=root)
        handles, labels = maps[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="lower center", ncols=_LEGEND_COLUMNS)
    return figure


def errors(name: str, trace: Mapping[str, Array], end_s: float | None = None) -> Figure:
    """Distance of each boat from its slot over time, logarithmic, with the settling level.

    The axis begins at the decade of the first percentile of the distances, between 10 µm and
    1 mm: boats may start in their slots, and pass through them. The last third before `end_s` is
    marked, by default the run's.
    """
    t_s = trace["t_s"]
    end_s = float(t_s[-1]) if end_s is None else end_s
    step = _step(t_s)
    distance = metrics.distances(trace["error"][::step])
    least_m = _least_decade(distance)
    # the logarithm of zero does not exist
    distance = np.maximum(distance, 0.1 * least_m)
    distance[~(distance < _FARTHEST_M)] = np.nan
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(_WIDTH_IN, 4.6))
        figure.subplots_adjust(left=0.12, right=0.9, bottom=0.11, top=0.93)
        axes = figure.add_subplot(yscale="log", xlabel="time since release (s)")
        lost = "" if np.isfinite(distance).all() else "; a line ends where it is not finite"
        axes.set_title(f"{name}: distance of each boat from its slot{lost}")
        axes.set_ylabel("formation error |e| (m)")
        for i in range(distance.shape[1]):
            axes.plot(t_s[::step], distance[:, i], color=colour_of(i + 1))
        axes.axhline(metrics.SETTLED_M, color=BLACK, lw=1.0, ls=DASHED)
        by_level = axes.get_yaxis_transform()
        level = f"settled: {metrics.SETTLED_M} m"
        text = axes.text(0.01, metrics.SETTLED_M * 0.9, level, fontsize=9.5, va="top")
        text.set(transform=by_level, path_effects=[HALO])
        third = t_s[0] + (end_s - t_s[0]) * 2.0 / 3.0
        axes.axvspan(third, end_s, color=FAINT, zorder=0)
        by_time = axes.get_xaxis_transform()
        axes.text(third, 0.97, " last third: RMS, maximum", color=GREY, va="top", transform=by_time)
        axes.set_xlim(t_s[0], t_s[-1])
        axes.set_ylim(bottom=least_m)
        plain_decades(axes)
        _label_ends(axes, np.maximum(_last_finite(distance), least_m))
    return figure


def thrust(
    name: str, trace: Mapping[str, Array], limits_N: Sequence[tuple[float, float]] = ()
) -> Figure:
    """Port and starboard thrust of each boat over time, on one scale; short peaks as numbers.

    `limits_N`: for each boat, least and greatest thrust of one propeller. They are drawn as lines
    if the scale reaches them; times at which a propeller is at a limit are marked.
    """
    t_s, values = trace["t_s"], trace["thrust"]
    step, count = _step(t_s), values.shape[1]
    low, high = np.quantile(values[np.isfinite(values)], [0.001, 0.999])
    margin = 0.1 * max(high - low, 0.1)
    with matplotlib.rc_context(STYLE):
        height_in = 1.3 + 1.4 * count
        figure = Figure(figsize=(_WIDTH_IN, height_in))
        _lay_out(figure, height_in, between=0.26)
        rows = figure.subplots(count, 1, sharex=True, sharey=True, squeeze=False)[:, 0]
        for i, axes in enumerate(rows):
            axes.plot(t_s[::step], values[::step, i, 0], color=COLOURS[1], label="port")
            axes.plot(t_s[::step], values[::step, i, 1], color=COLOURS[2], label="starboard")
            axes.set_ylabel(f"boat {i + 1} (N)")
            if limits_N:
                _mark_limits(axes, t_s, values[:, i], limits_N[i])
            least, most = np.fmin.reduce(values[:, i], None), np.fmax.reduce(values[:, i], None)
            if least < low - margin or most > high + margin:
                text = f"from {least:.1f} to {most:.1f} N".replace("-", "−")
                axes.text(
                    1.0, 1.0, text, color=GREY, ha="right", va="bottom", transform=axes.transAxes
                )
        rows[0].set_ylim(low - margin, high + margin)
        rows[0].set_xlim(t_s[0], t_s[-1])
        figure.suptitle(f"{name}: propeller thrust", x=0.01, ha="left")
        rows[-1].set_xlabel("time since release (s)")
        handles, labels = rows[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="lower center", ncols=2)
    return figure


def _lay_out(figure: Figure, height_in: float, between: float, rows: int = 1) -> None:
    """Set the margins directly: matplotlib would take longer to find them than to draw."""
    bottom, top = (0.6 + 0.25 * rows) / height_in, 1.0 - 0.6 / height_in
    figure.subplots_adjust(left=0.1, right=0.97, bottom=bottom, top=top, hspace=between)


def _mark_limits(axes: Axes, t_s: Array, thrust_N: Array, limits_N: tuple[float, float]) -> None:
    """Lines at the limits, and a mark along the top while either propeller is at one."""
    low, high = limits_N
    for limit in limits_N:
        axes.axhline(limit, color=BAD, lw=0.9, ls=DASHED, zorder=1)
    slack = _AT_LIMIT * (high - low)
    full = ((thrust_N >= high - slack) | (thrust_N <= low + slack)).any(axis=1)
    share = float(full.mean())
    text = f"limits {low:g} and {high:g} N".replace("-", "−")
    if share > 0.0:
        edges = np.flatnonzero(np.diff(np.concatenate([[False], full, [False]])))
        begins, ends = t_s[edges[::2]], t_s[edges[1::2] - 1]
        shown = np.maximum(ends - begins, 1e-3 * np.ptp(t_s))  # a single tick must be visible too
        along_top = axes.get_xaxis_transform()
        spans = list(zip(begins, shown, strict=True))
        axes.broken_barh(spans, (0.94, 0.06), transform=along_top, color=BAD)
        text += f"; at one for {share:.1%} of the time"
    colour = BAD if share > 0.0 else GREY
    axes.text(0.0, 1.0, text, color=colour, fontsize=9, va="bottom", transform=axes.transAxes)


def plain_decades(axes: Axes) -> None:
    """Mark a logarithmic ordinate at its decades alone, "0.01" rather than a power of ten.

    Powers need a parser that takes as long as a whole picture; minor ticks take longer than all
    lines.
    """
    axes.yaxis.set_minor_locator(NullLocator())
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: decimal(value)))


def decimal(value: float) -> str:
    """The label of a tick, which may be 9.999999999999999e-06: "0.00001"."""
    return np.format_float_positional(value, precision=3, fractional=False, trim="-")


def draw_map(
    axes: Axes,
    t_s: Array,
    eta: Array,
    *,
    formations: int,
    hull_share: float,
    root: str = VIRTUAL_LEADER,
) -> None:
    """Paths of `eta` (T, N+1, 3), north up, with the formation at evenly spaced times.

    A hull is drawn 1 m long, or `hull_share` of the paths' extent if that is more. `root`: agent
    0's name.
    """
    axes.set_aspect("equal", adjustable="datalim")
    axes.set(xlabel="east (m)", ylabel="north (m)")
    axes.margins(0.05)
    path = eta[:: _step(t_s)]
    north, east = path[..., 0], path[..., 1]
    extent_m = float(max(np.ptp(north), np.ptp(east), 1.0))
    (leader,) = axes.plot(east[:, 0], north[:, 0], color=BLACK, lw=1.0, zorder=3)
    leader.set(linestyle=DASHED, label=root)
    for boat in range(1, eta.shape[1]):
        label = f"boat {boat}"
        axes.plot(east[:, boat], north[:, boat], color=colour_of(boat), lw=1.0, label=label)
    axes.plot(east[0, 1:], north[0, 1:], "o", ms=11, mfc="none", mec=GREY, label="start")
    length_m = max(1.0, hull_share * extent_m)
    order = around(eta[-1, 1:])
    for k in np.linspace(0, t_s.size - 1, formations).astype(int):
        poses = eta[k, 1:]
        ring = poses[[*order, order[0]]]
        axes.plot(ring[:, 1], ring[:, 0], color=GREY, lw=0.8, zorder=4)
        hulls = PolyCollection([outline(pose, length_m) for pose in poses], zorder=5)
        hulls.set(
            facecolor=[colour_of(i + 1) for i in range(len(poses))], edgecolor="white", lw=0.4
        )
        axes.add_collection(hulls)
        top = poses[np.argmax(poses[:, 0])]
        text = axes.annotate(
            f"{t_s[k]:.0f} s", (top[1], top[0]), (0, 9), textcoords="offset points"
        )
        text.set(ha="center", fontsize=9.5, zorder=6, path_effects=[HALO])


def around(eta: Array) -> list[int]:
    """Boats in order around their centre, so that lines that join them do not cross."""
    north, east = (eta[:, :2] - eta[:, :2].mean(axis=0)).T
    return list(np.argsort(np.arctan2(east, north)))


def outline(pose: Array, length_m: float) -> Array:
    """Outline (K, 2) as [east north] of a hull at [x y ψ]."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    forward, starboard = length_m * _OUTLINE.T
    north, east = cos * forward - sin * starboard, sin * forward + cos * starboard
    return np.column_stack([pose[1] + east, pose[0] + north])


def _label_ends(axes: Axes, values: Array) -> None:
    """Name the boats beside the ends of their lines, moved apart where they would overlap."""
    gap = 0.06
    low, high = np.log10(axes.get_ylim())
    wanted = (np.log10(values) - low) / (high - low)
    order = np.argsort(wanted)
    steps = gap * np.arange(order.size)
    # pushed up from below and down from above; the mean keeps a bunch around its place
    pushed_up = np.maximum.accumulate(wanted[order] - steps) + steps
    pushed_down = np.minimum.accumulate((wanted[order] - steps)[::-1])[::-1] + steps
    for i, place in zip(order, (pushed_up + pushed_down) / 2.0, strict=True):
        text = axes.text(1.01, place, f"boat {i + 1}", color=colour_of(i + 1), va="center")
        text.set_transform(axes.transAxes)


def _drawable(eta: Array) -> int:
    """Number of ticks of `eta` (T, N+1, 3) before an agent is too far from its start."""
    # "not less" rather than "more": NaN counts as too far
    lost = ~(np.abs(eta[..., :2] - eta[0, :, :2]) < _FARTHEST_M) | ~np.isfinite(eta[..., 2:])
    lost_ticks = np.flatnonzero(lost.any(axis=(1, 2)))
    return max(1, int(lost_ticks[0])) if lost_ticks.size else len(eta)


def _least_decade(distance: Array) -> float:
    seen = distance[np.isfinite(distance) & (distance > 0.0)]
    least_m = float(np.quantile(seen, 0.01)) if seen.size else _MOST_LEAST_M
    return float(10.0 ** np.floor(np.log10(np.clip(least_m, _LEAST_M, _MOST_LEAST_M))))


def _last_finite(values: Array) -> Array:
    """Last finite value (N) of each column of `values` (T, N); the settling level if none."""
    found = np.full(values.shape[1], metrics.SETTLED_M)
    for row in values:
        found = np.where(np.isfinite(row), row, found)
    return found


def _height_to_width(eta: Array) -> float:
    north_m, east_m = np.ptp(eta[..., 0]), np.ptp(eta[..., 1])
    return float(np.clip(north_m / max(east_m, 1e-9), 0.35, 0.8))


def _step(t_s: Array) -> int:
    return max(1, t_s.size // _SHOWN_SAMPLES)
