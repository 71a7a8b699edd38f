# SPDX-License-Identifier: MIT
"""Draws a run's pictures in a separate process, which loads matplotlib while the boats sail."""

import io
import multiprocessing
import signal
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from multiprocessing.connection import Connection
from typing import Any, Self

from sil.plant.hull import Array

CAN_DRAW = find_spec("matplotlib") is not None
Pictures = dict[str, bytes]
_DRAWN = ("t_s", "eta", "error", "thrust")
_Order = tuple[str, Mapping[str, Array], Sequence[tuple[float, float]], str, float | None]


def draw(
    name: str,
    trace: Mapping[str, Array],
    limits_N: Sequence[tuple[float, float]] = (),
    root: str = "virtual leader",
    end_s: float | None = None,
) -> Pictures:
    """The PNGs of a run: "formation", "errors" and "thrust"; arguments as `sil.report.plots`.

    Returns no pictures without matplotlib, which only the extra [view] installs.
    """
    if not CAN_DRAW:
        return {}
    from sil.report import plots  # noqa: PLC0415  loads matplotlib

    figures = {
        "formation": plots.formation(name, trace, root),
        "errors": plots.errors(name, trace, end_s),
        "thrust": plots.thrust(name, trace, limits_N),
    }
    pictures = {}
    for stem, figure in figures.items():
        png = io.BytesIO()
        # a tenth larger than with the default level, in two thirds of the time
        figure.savefig(png, format="png", pil_kwargs={"compress_level": 1})
        pictures[stem] = png.getvalue()
    return pictures


class Drawing:
    """A context manager: call `begin` once the trace exists; `pictures` waits for the result."""

    def __init__(self) -> None:
        context: Any = multiprocessing.get_context("fork")
        self._ours, theirs = context.Pipe()
        self._process = context.Process(target=_serve, args=(theirs, self._ours), daemon=True)
        self._order: _Order | None = None

    def __enter__(self) -> Self:
        self._process.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.join()
        self._ours.close()

    @property
    def process_id(self) -> int:
        """Id of the process that draws."""
        return int(self._process.pid)

    def begin(
        self,
        name: str,
        trace: Mapping[str, Array],
        limits_N: Sequence[tuple[float, float]],
        root: str = "virtual leader",
        end_s: float | None = None,
    ) -> None:
        """Order the pictures; arguments as `draw`."""
        self._order = (name, {array: trace[array] for array in _DRAWN}, limits_N, root, end_s)
        try:
            self._ours.send(self._order)
        except OSError:
            return  # the process is gone; pictures() draws them here

    def pictures(self) -> Pictures:
        """The pictures; this process draws them if the other one cannot."""
        assert self._order is not None
        try:
            drawn: Pictures = self._ours.recv()
        except (EOFError, OSError):
            return draw(*self._order)
        return drawn


def _serve(orders: Connection, other_end: Connection) -> None:
    """Draw one order. Ctrl-C is left to the parent process, whose end closes the pipe."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    other_end.close()
    if CAN_DRAW:
        from sil.report import plots  # noqa: F401, PLC0415  loads matplotlib while the boats sail
    try:
        orders.send(draw(*orders.recv()))
    except (EOFError, OSError):
        return  # the run ended without a trace
