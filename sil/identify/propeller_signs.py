# SPDX-License-Identifier: MIT
"""Signs of the propellers, found before any fit: inverted, swapped, or correct.

Over each second, Δu = a_p ∫f(c_p) + a_s ∫f(c_s) − d ∫u and Δr = b_p ∫f(c_p) + b_s ∫f(c_s) −
d' ∫r − d'' ∫|u| r, by least squares. Port and starboard ahead push ahead (a > 0); port turns to
starboard (b_p > 0), starboard to port (b_s < 0).
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from sil.identify.voyage_log import SAMPLE_S, Array, BadLogError, VoyageLog

_STEP = round(1.0 / SAMPLE_S)
_SURE = 4.0  # standard errors
_LEAST_COMMAND = 0.05
_ROUNDING = 1e-6  # of commands
_APART = 0.1  # of the sum's deviation: a smaller one of the difference cannot turn the boat


@dataclass(frozen=True)
class Wiring:
    """How the propellers are connected.

    surge, yaw: (a_p, a_s), (b_p, b_s) from the logs, in standard errors.
    """

    port_inverted: bool
    stbd_inverted: bool
    swapped: bool
    surge: tuple[float, float]
    yaw: tuple[float, float]

    @property
    def right(self) -> bool:
        """Whether the wiring is correct."""
        return not (self.port_inverted or self.stbd_inverted or self.swapped)

    def sentence(self) -> str:
        """The fault and its remedy, for the report."""
        sides = [
            side
            for side, inverted in (("port", self.port_inverted), ("starboard", self.stbd_inverted))
            if inverted
        ]
        told = []
        if sides:
            told.append(
                f"the propeller that the log calls {' and '.join(sides)} pushes astern when it is "
                "commanded ahead"
            )
        if self.swapped:
            told.append(
                "port and starboard are swapped: exchange ESC_PORT and ESC_STBD. If you already "
                "have, the log lacks the new values: request the boat's parameters while it logs"
            )
        return "; ".join(told)


def find(logs: Sequence[VoyageLog]) -> Wiring:
    """The wiring in these logs of one boat. Raises `BadLogError` if they do not show it."""
    rows = [_rows(log) for log in logs]
    surge = _standard_errors(np.vstack([a for a, _ in rows]))
    yaw = _standard_errors(np.vstack([b for _, b in rows]))
    names = ", ".join(log.name for log in logs)
    inverted = surge[0] < 0.0, surge[1] < 0.0
    turns = [b * (-1.0 if wrong else 1.0) for b, wrong in zip(yaw, inverted, strict=True)]
    silent = max(abs(surge[0]), abs(surge[1])) < _SURE or min(abs(yaw[0]), abs(yaw[1])) < _SURE
    one_sided = turns[0] * turns[1] > 0.0
    if (silent or one_sided) and _alike(logs):
        raise BadLogError(
            f"{names}: the difference between both propellers hardly changes, so nobody can tell "
            "them apart. Add a log of the voyage, or of turns to both sides."
        )
    if silent:
        raise BadLogError(
            f"{names}: the boat does not answer its propellers. "
            "Check that commands and motion are of the same boat and time, in the units that "
            "their columns name, and that the log has turns and straights."
        )
    if one_sided:
        raise BadLogError(
            f"{names}: both propellers turn the boat to the same "
            "side. One column of commands or the yaw rate is not what its name says."
        )
    return Wiring(*inverted, turns[0] < 0.0, surge, yaw)


def _alike(logs: Sequence[VoyageLog]) -> bool:
    """Whether both propellers are driven, but their difference stays nearly the same."""
    commands = np.vstack([log.commands for log in logs])
    apart = np.nanstd(commands[:, 0] - commands[:, 1])
    together = np.nanstd(commands.sum(axis=1))
    driven = np.nanmax(np.abs(commands), initial=0.0) > _LEAST_COMMAND
    return bool(driven and apart <= max(_APART * together, _ROUNDING))


def mended(log: VoyageLog, wiring: Wiring) -> VoyageLog:
    """The log as if the boat had been wired correctly."""
    signs = np.array([-1.0 if wiring.port_inverted else 1.0, -1.0 if wiring.stbd_inverted else 1.0])
    commands = log.commands * signs
    return replace(log, commands=commands[:, ::-1] if wiring.swapped else commands)


def _rows(log: VoyageLog) -> tuple[Array, Array]:
    """Rows (change, ∫f(c_p), ∫f(c_s), ∫motion …) for surge and yaw."""
    count = (len(log.motion) - 1) // _STEP
    at = np.arange(count + 1) * _STEP
    u, r = log.motion[:, 3], log.motion[:, 5]
    thrust = log.commands * (0.6 + 0.4 * np.abs(log.commands))
    # A command reaches the motion a few samples later.
    late = np.vstack([np.zeros((2, 2)), thrust[:-2]])

    def area(x: Array) -> Array:
        sums: Array = x[: count * _STEP].reshape(count, _STEP, -1).sum(axis=1) * SAMPLE_S
        return sums

    surge = np.column_stack([np.diff(u[at]), area(np.column_stack([late, u, np.abs(u) * u]))])
    yaw = np.column_stack([np.diff(r[at]), area(np.column_stack([late, r, np.abs(u) * r]))])
    return tuple(  # type: ignore[return-value]
        rows[np.all(np.isfinite(rows), axis=1)] for rows in (surge, yaw)
    )


def _standard_errors(rows: Array) -> tuple[float, float]:
    """Coefficients of the two propellers over their standard errors."""
    if len(rows) < 20 or np.abs(rows[:, 1:3]).max() < _LEAST_COMMAND * SAMPLE_S:
        return 0.0, 0.0
    a, y = rows[:, 1:], rows[:, 0]
    inverse = np.linalg.pinv(a.T @ a)
    x = inverse @ a.T @ y
    noise = ((y - a @ x) ** 2).sum() / max(len(y) - a.shape[1], 1)
    sure = x[:2] / np.sqrt(np.maximum(noise * np.diag(inverse)[:2], 1e-30))
    return float(sure[0]), float(sure[1])
