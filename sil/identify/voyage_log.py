# SPDX-License-Identifier: MIT
"""The form of a log for an identification: motion and commands at one rate, in one frame."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]

SAMPLE_S = 0.1
_GAP_S = 0.55  # a longer silence is no measurement
_CHANNELS = 6


class BadLogError(ValueError):
    """A log that cannot be used; the sentence names the file, the place and the remedy."""


@dataclass(frozen=True)
class VoyageLog:
    """One voyage, sampled every `SAMPLE_S`.

    motion (T, 6): north, east (m), heading (rad, unwrapped), u, v over ground (m/s), r (rad/s);
    NaN where nothing was measured. commands (T, 2): port, starboard, −1 … 1, the mean over the
    sample that begins there. fresh: share of the position's samples that were new in the log.
    """

    name: str
    motion: Array
    commands: Array
    fresh: float = 1.0

    @property
    def duration_s(self) -> float:
        """Length of the voyage."""
        return len(self.motion) * SAMPLE_S


@dataclass(frozen=True)
class Channel:
    """A series as read from a file: times (s) and values (samples, columns)."""

    t_s: Array
    values: Array


def sampled(name: str, motion: list[Channel], commands: Channel) -> VoyageLog:
    """One log from series with different times; motion: position, heading, (u, v), r."""
    begin = max(c.t_s[0] for c in (*motion, commands))
    end = min(c.t_s[-1] for c in (*motion, commands))
    count = int((end - begin) / SAMPLE_S + 1e-6)
    if count < 100:
        raise BadLogError(
            f"{name}: motion and commands overlap for only {max(end - begin, 0.0):.0f} s; "
            "an identification needs minutes. Log both at the same time."
        )
    for what, channel in (
        ("speed", motion[2]),
        ("yaw rate", motion[3]),
        ("heading", motion[1]),
        ("position", motion[0]),
    ):
        known = channel.t_s[np.isfinite(channel.values[:, 0])]
        if len(known) < 2:
            raise BadLogError(f"{name}: the {what} has no values")
        every_s = np.median(np.diff(known))
        if every_s > _GAP_S:
            raise BadLogError(
                f"{name}: the {what} comes at {1.0 / every_s:.2g} Hz; 2 Hz or more is needed"
            )
    t = begin + np.arange(count) * SAMPLE_S
    columns = [_at(c, t) for c in motion]
    steady = np.hstack(columns)
    if steady.shape[1] != _CHANNELS:
        raise ValueError(f"{steady.shape[1]} columns of motion, not {_CHANNELS}")
    return VoyageLog(name, steady, _held(commands, t), _fresh(motion[0]))


def _at(channel: Channel, t: Array) -> Array:
    """Interpolates linearly; NaN in gaps and beside missing values."""
    out = np.empty((len(t), channel.values.shape[1]))
    for k, column in enumerate(channel.values.T):
        known = np.isfinite(column)
        if known.sum() < 2:
            out[:, k] = np.nan
            continue
        times = channel.t_s[known]
        out[:, k] = np.interp(t, times, column[known], left=np.nan, right=np.nan)
        after = np.clip(np.searchsorted(times, t), 1, len(times) - 1)
        out[times[after] - times[after - 1] > _GAP_S, k] = np.nan
    return out


def _held(commands: Channel, t: Array) -> Array:
    """Mean command over each sample; a command holds until the next one, 0 before the first."""
    times = np.append(commands.t_s, t[-1] + 1.0)
    rows = np.arange(len(commands.values))[:, None]
    last = np.maximum.accumulate(np.where(np.isfinite(commands.values), rows, 0))
    held = np.nan_to_num(np.take_along_axis(commands.values, last, axis=0))
    area = np.vstack([np.zeros(2), np.cumsum(held * np.diff(times)[:, None], axis=0)])
    edges = np.append(t, t[-1] + SAMPLE_S)
    at = np.column_stack([np.interp(edges, times, column) for column in area.T])
    mean: Array = np.diff(at, axis=0) / SAMPLE_S
    return mean


def _fresh(position: Channel) -> float:
    moved = np.any(np.diff(position.values, axis=0) != 0.0, axis=1)
    return float(np.mean(moved)) if len(moved) else 1.0
