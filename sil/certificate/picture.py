# SPDX-License-Identifier: MIT
"""The picture of a certificate: decay over k_x, one panel for each motion of the leader."""

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sil.certificate import verdict
from sil.certificate.certificate import Case, Leg
from sil.certificate.gains import CURVE_K_X
from sil.certificate.small_gain import MOST_K_X
from sil.common.colours import BLACK, FAINT, GREY, colour_of
from sil.plant.hull import Array
from sil.report import plots

_WIDTH_IN, _PANEL_IN = 8.0, 4.2
_LEAST, _MOST = -0.1, 1.0
_TICKS = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)


def decay(name: str, legs: Sequence[Leg]) -> Figure:
    """Decay of eq:26 and of the sampled loops over k_x, for the legs on which the leader moves."""
    shown = [leg for leg in legs if leg.cases[0].curve_sampled]
    with matplotlib.rc_context(plots.STYLE):
        height_in = 0.9 + _PANEL_IN * max(1, len(shown))
        figure = Figure(figsize=(_WIDTH_IN, height_in), layout="constrained")
        panels = figure.subplots(max(1, len(shown)), 1, squeeze=False)[:, 0]
        for axes, leg in zip(panels, shown, strict=False):
            _draw(axes, leg)
            since = ", ".join(f"{t:g}" for t in leg.from_s)
            where = "" if len(legs) == 1 else f", leader's input from {since} s on"
            axes.set_title(f"{name}: how fast small errors decay{where}")
        if not shown:
            panels[0].set_title(f"{name}: the leader never moves")
        panels[-1].set_xlabel("gain k_x (1/s)")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=2)
    return figure


def _draw(axes: Axes, leg: Leg) -> None:
    axes.set_xscale("log")
    axes.set_ylabel("decay of the slowest mode (1/s)")
    k_x = np.array(CURVE_K_X)
    slowest = min(leg.cases, key=lambda case: min(case.curve_sampled))
    for boats, case in _distinct(leg.cases):
        _draw_case(axes, k_x, boats, case)
    (line,) = axes.plot(k_x, slowest.curve_floquet, color=BLACK, lw=1.0, zorder=4)
    line.set(linestyle=plots.DASHED, label="the paper's nominal loop (24)")
    _certified(axes, slowest.small_gain.k_x_square_of_sum)
    chosen = slowest.setup.parameters["LAW_KX"]
    axes.axvline(chosen, color=GREY, lw=0.8, zorder=0)
    by_height = axes.get_xaxis_transform()
    text = f" k_x = {chosen:g}"
    axes.text(chosen, 0.97, text, color=GREY, va="top", transform=by_height)
    values = np.concatenate(
        [[*c.curve_floquet, *c.curve_sampled, *c.curve_of_law, c.sampled.decay] for c in leg.cases]
    )
    axes.set_xlim(k_x[0], k_x[-1])
    axes.set_xticks(_TICKS, [f"{tick:g}" for tick in _TICKS])
    axes.minorticks_off()
    low, high = max(_LEAST, min(0.0, values.min())), min(_MOST, max(0.05, values.max()))
    axes.set_ylim(low - 0.03 * (high - low), high + 0.25 * (high - low))
    axes.axhline(0.0, color=GREY, lw=0.8)


def _distinct(cases: Sequence[Case]) -> list[tuple[list[int], Case]]:
    """Distinct cases: each stands for all boats whose lines would coincide with its own."""
    found: list[tuple[list[int], Case]] = []
    for case in cases:
        for boats, other in found:
            if _same_line(case.curve_sampled, other.curve_sampled) and _same_line(
                case.curve_of_law, other.curve_of_law
            ):
                boats.extend(case.boats)
                break
        else:
            found.append((list(case.boats), case))
    return found


def _same_line(a: Sequence[float], b: Sequence[float]) -> bool:
    scale = np.maximum(0.02, np.abs(b))
    return bool((np.abs(np.array(a) - b) < 0.04 * scale).all())


def _draw_case(axes: Axes, k_x: Array, boats: list[int], case: Case) -> None:
    colour, name = colour_of(boats[0]), verdict.name(sorted(boats))
    axes.plot(k_x, case.curve_sampled, color=colour, lw=2.2, label=f"sampled loop, {name}")
    if np.max(np.array(case.curve_of_law) - case.curve_sampled) > 1e-3:
        label = f"LAW_OBS_BW = LAW_CUR_BW = 0, {name}"
        axes.plot(k_x, case.curve_of_law, color=colour, lw=1.4, ls=":", label=label)
    chosen, decay_now = case.setup.parameters["LAW_KX"], case.sampled.decay
    axes.plot([chosen], [decay_now], "o", ms=7, color=colour, mec="white", zorder=5)


def _certified(axes: Axes, k_x: float | None) -> None:
    by_height = axes.get_xaxis_transform()
    low = CURVE_K_X[0]
    if k_x is None or k_x < low:
        text = "small-gain test:\nno k_x from 0.01 on"
        axes.text(low * 1.06, 0.97, text, color=GREY, va="top", transform=by_height)
        return
    axes.axvspan(low, min(k_x, CURVE_K_X[-1]), color=FAINT, zorder=-1)
    up_to = f"over {MOST_K_X:g}" if k_x >= MOST_K_X else f"{k_x:.3f}"
    text = f"small-gain test:\nk_x up to {up_to}"
    axes.text(low * 1.06, 0.97, text, color=GREY, va="top", transform=by_height)
