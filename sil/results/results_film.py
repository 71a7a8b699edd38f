# SPDX-License-Identifier: MIT
"""The README's moving picture, diamond.gif: python -m sil.results.results_film out/demo."""

import argparse
import io
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from PIL import Image

from sil.common import files
from sil.common.colours import BLACK, FAINT, GREY, colour_of
from sil.lockstep import metrics
from sil.plant.hull import Array
from sil.report.plots import DASHED, STYLE, around, outline
from sil.results.published import PICTURES

FILM = PICTURES / "diamond.gif"
_UNTIL_S, _STEP_S, _FRAME_MS = 60.0, 0.5, 80
_LAST_MS = 3000  # the formation stays still before the film repeats
_TAIL_S = 8.0
_HULL_M = 2.0  # drawn 1.5 times their length


def film(trace: Mapping[str, Array]) -> bytes:
    """A GIF of the run's first minute: hulls, paths, slots, and distances from the slots."""
    t_s, wanted = trace["t_s"], np.arange(0.0, _UNTIL_S + _STEP_S, _STEP_S)
    ticks = np.searchsorted(t_s, wanted[wanted <= t_s[-1]] - 1e-6)
    frames = [_frame(trace, tick, ticks[-1]) for tick in ticks]
    # one palette for all frames, so that colours do not flicker
    palette = frames[len(frames) // 2].quantize(64, dither=Image.Dither.NONE)
    small = [frame.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    durations = [_FRAME_MS] * (len(small) - 1) + [_LAST_MS]
    out = io.BytesIO()
    small[0].save(
        out,
        "gif",
        save_all=True,
        append_images=small[1:],
        duration=durations,
        loop=0,
        optimize=True,
    )
    return out.getvalue()


def slots(eta: Array, error: Array) -> Array:
    """Positions (N, 2), north and east, of the boats' slots; `eta` (N, 3), `error` (N, 3)."""
    cos, sin = np.cos(eta[:, 2]), np.sin(eta[:, 2])
    ahead, starboard = error[:, 0], error[:, 1]
    return eta[:, :2] - np.column_stack(
        [cos * ahead - sin * starboard, sin * ahead + cos * starboard]
    )


def _frame(trace: Mapping[str, Array], tick: int, last: int) -> Image.Image:
    with matplotlib.rc_context(STYLE):
        figure = Figure(figsize=(8.0, 4.2), dpi=90, layout="constrained")
        sea, bars = figure.subplots(1, 2, width_ratios=(5, 1))
        _draw_sea(sea, trace, tick, last)
        _draw_bars(bars, metrics.distances(trace["error"][tick]))
        sea.set_title(f"{trace['t_s'][tick]:.0f} s")
        drawn = io.BytesIO()
        figure.savefig(drawn, format="png", dpi=90)
    with Image.open(drawn) as image:
        return image.convert("RGB")


def _draw_sea(axes: Axes, trace: Mapping[str, Array], tick: int, last: int) -> None:
    t_s, eta = trace["t_s"], trace["eta"]
    axes.set_aspect("equal")
    axes.set(xlabel="east (m)", ylabel="north (m)")
    whole = eta[: last + 1].reshape(-1, 3)
    axes.set_xlim(whole[:, 1].min() - _HULL_M, whole[:, 1].max() + _HULL_M)
    axes.set_ylim(whole[:, 0].min() - _HULL_M, whole[:, 0].max() + _HULL_M)
    tail = eta[np.searchsorted(t_s, t_s[tick] - _TAIL_S) : tick + 1]
    axes.plot(tail[:, 0, 1], tail[:, 0, 0], color=BLACK, lw=1.0, linestyle=DASHED)
    boats = eta[tick, 1:]
    places = slots(boats, trace["error"][tick])
    ring = places[around(places)]
    axes.fill(ring[:, 1], ring[:, 0], color=FAINT, edgecolor=GREY, lw=0.6)
    for boat, (north, east) in enumerate(places, start=1):
        axes.plot(tail[:, boat, 1], tail[:, boat, 0], color=colour_of(boat), lw=1.0)
        axes.plot(east, north, "o", ms=18, mfc="none", mec=colour_of(boat), lw=0.8)
    hulls = PolyCollection([outline(pose, _HULL_M) for pose in boats], zorder=5)
    hulls.set(facecolor=[colour_of(i + 1) for i in range(len(boats))], edgecolor="white", lw=0.4)
    axes.add_collection(hulls)


def _draw_bars(axes: Axes, distance_m: Array) -> None:
    axes.set_title("off the slot")
    axes.set(xlim=(0.0, 10.0), ylim=(-distance_m.size - 0.5, -0.3), xticks=[], yticks=[])
    axes.spines["bottom"].set_visible(False)
    axes.grid(False)
    for boat, metres in enumerate(distance_m, start=1):
        axes.barh(-boat, metres, height=0.35, color=colour_of(boat))
        axes.text(0.0, 0.32 - boat, f"boat {boat}: {metres:.2f} m", color=GREY, fontsize=10)


def main(arguments: Sequence[str]) -> int:
    """Write the film of a run's folder; exit status 0."""
    parser = argparse.ArgumentParser(prog="python -m sil.results.results_film", description=__doc__)
    parser.add_argument("run", type=Path, help="folder of a run, as out/demo")
    parser.add_argument("--out", type=Path, default=FILM, help=f"file ({FILM})")
    options = parser.parse_args(arguments)
    with np.load(options.run / "trace.npz") as trace:
        files.replace(options.out, film(dict(trace)))
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
