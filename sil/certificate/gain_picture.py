# SPDX-License-Identifier: MIT
"""The picture of a chain: gains over frequency, for one hop and from the root to the boats."""

from collections.abc import Sequence

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from sil.certificate.certificate import Leg
from sil.certificate.chain import Chain, Gains
from sil.common.colours import BLACK, COLOURS, GREY
from sil.report import plots

_WIDTH_IN, _PANEL_IN = 8.0, 3.6
_SHOWN = (2, 3, 5, 10, 15, 20)
_LEAST, _MOST = 0.03, 300.0
_TICKS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
_GAINS = (0.1, 1.0, 10.0, 100.0)


def gains(name: str, legs: Sequence[Leg]) -> Figure | None:
    """Gains in yaw and surge behind each leader that moves; None if there is no chain."""
    shown = [(leg, leg.chain) for leg in legs if isinstance(leg.chain, Chain)]
    if not shown:
        return None
    with matplotlib.rc_context(plots.STYLE):
        figure = Figure(figsize=(_WIDTH_IN, 0.9 + 2 * _PANEL_IN * len(shown)), layout="constrained")
        panels = figure.subplots(2 * len(shown), 1, squeeze=False)[:, 0]
        for k, (leg, chain) in enumerate(shown):
            where = "" if len(legs) == 1 else f", leader's input from {leg.from_s[0]:g} s on"
            for axes, of, what in zip(
                panels[2 * k :], (chain.yaw, chain.surge), ("yaw rate", "speed"), strict=False
            ):
                _draw(axes, chain, of)
                axes.set_title(f"{name}: gain of {what}{where}")
        panels[-1].set_xlabel("frequency (rad/s)")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def _draw(axes: Axes, chain: Chain, gains: Gains) -> None:
    depths = [d for d in _SHOWN if d < len(chain.path)] + [len(chain.path)]
    for k, depth in enumerate(depths):
        colour = COLOURS[k % len(COLOURS)]
        boat = f"root to boat {chain.path[depth - 1]}"
        axes.plot(gains.omega, gains.root[depth - 1], color=colour, label=boat)
    hop = "one hop" if not chain.reference else "one hop, boat 2 pushed"
    (line,) = axes.plot(gains.omega, gains.hop, color=BLACK, lw=2.2, label=hop)
    line.set(linestyle=plots.DASHED)
    axes.axhline(1.0, color=GREY, lw=0.8)
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(_TICKS[0], 16.0)
    axes.set_xticks(_TICKS, [f"{tick:g}" for tick in _TICKS])
    top = np.nanmax([np.nanmax(gains.root[depth - 1]) for depth in depths])
    axes.set_ylim(_LEAST, float(np.clip(2.0 * top, 3.0, _MOST)))
    axes.set_yticks([g for g in _GAINS if g < axes.get_ylim()[1]])
    axes.set_yticklabels([f"{g:g}" for g in _GAINS if g < axes.get_ylim()[1]])
    axes.minorticks_off()
    axes.set_ylabel("gain")
