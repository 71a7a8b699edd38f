# SPDX-License-Identifier: MIT
"""Windows: stretches of logs that are simulated in open loop, side by side."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from sil.identify.voyage_log import SAMPLE_S, Array, VoyageLog
from sil.identify.voyage_model import before

WINDOW_S = 10.0
_WORKING = 0.05  # of full command
_MOVING = 0.05  # m/s, rad/s
_EARLY = 5  # samples


@dataclass(frozen=True)
class Windows:
    """commands (before + samples, W, 2); measured (samples, 6, W), NaN where unknown; log (W)."""

    commands: Array
    measured: Array
    log: npt.NDArray[np.int64]
    start_s: Array

    def __len__(self) -> int:
        return len(self.log)

    def chosen(self, which: npt.NDArray[np.bool_]) -> "Windows":
        """The windows that a mask selects."""
        return Windows(
            self.commands[:, which],
            self.measured[:, :, which],
            self.log[which],
            self.start_s[which],
        )

    def begun(self, share: float) -> "Windows":
        """The first part of each window."""
        samples = round(share * len(self.measured))
        ahead = len(self.commands) - len(self.measured)
        return replace(
            self, commands=self.commands[: ahead + samples], measured=self.measured[:samples]
        )

    def working(self) -> npt.NDArray[np.bool_]:
        """Mask of the windows in which the propellers work for a tenth of the time or more."""
        inside = np.abs(self.commands[before(SAMPLE_S) :]).max(axis=2) > _WORKING
        share: npt.NDArray[np.bool_] = inside.mean(axis=0) > 0.1
        return share


def cut(logs: Sequence[VoyageLog], stride_s: float = WINDOW_S) -> Windows:
    """Every stretch in which the boat moves or is driven."""
    ahead, samples = before(SAMPLE_S), round(WINDOW_S / SAMPLE_S)
    commands, measured, which, starts = [], [], [], []
    for number, log in enumerate(logs):
        padded = np.vstack([np.zeros((ahead, 2)), log.commands])
        for at in range(0, len(log.motion) - samples + 1, round(stride_s / SAMPLE_S)):
            given = padded[at : at + ahead + samples]
            motion = log.motion[at : at + samples]
            idle = np.abs(given).max() < _WORKING
            still = not np.nanmax(np.abs(motion[:, 3:]), initial=0.0) > _MOVING
            if (idle and still) or np.isfinite(motion).mean() < 0.5:
                continue
            commands.append(given)
            measured.append(_from_first_turn(motion).T)
            which.append(number)
            starts.append(at * SAMPLE_S)
    if not commands:
        shape = (ahead + samples, 0, 2), (samples, 6, 0)
        return Windows(np.empty(shape[0]), np.empty(shape[1]), np.empty(0, np.int64), np.empty(0))
    return Windows(
        np.stack(commands, axis=1),
        np.moveaxis(np.stack(measured, axis=2), 0, 1),
        np.array(which),
        np.array(starts),
    )


def _from_first_turn(motion: Array) -> Array:
    """Shifts the heading by whole turns, to within half a turn of north at the window's start."""
    first = motion[np.isfinite(motion[:, 2]), 2]
    if len(first) == 0:
        return motion
    out = motion.copy()
    out[:, 2] -= 2.0 * np.pi * np.round(first[0] / (2.0 * np.pi))
    return out


def first_start(windows: Windows) -> Array:
    """State (6, W) with which each window begins as measured.

    Position and heading of the first sample; velocities on a straight line through the first.
    """
    t = np.arange(_EARLY) - (_EARLY - 1) / 2.0
    early = np.nan_to_num(windows.measured[:_EARLY])
    slope = np.einsum("s,skw->kw", t, early) / (t @ t)
    begin = early.mean(axis=0) + t[0] * slope
    return np.vstack([early[0, :3], begin[3:]])
