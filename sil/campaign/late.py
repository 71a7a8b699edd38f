# SPDX-License-Identifier: MIT
"""Percentiles of |e| over all runs, from the time on when boats should be in formation."""

import numpy as np

from sil.campaign.run_outcome import SETTLED_S
from sil.plant.hull import Array


def from_s(last_s: float) -> float:
    """Start of the interval that counts in a run that lasts `last_s`: 100 s, or half of it."""
    return min(SETTLED_S, 0.5 * last_s)


def percentiles(error_m: Array, percents: tuple[float, ...]) -> Array:
    """Percentiles (N, len(percents)) of distances `error_m` (N, R, S) at whole seconds 0 … S − 1.

    Taken over all runs and the seconds from `from_s` on, without interpolation, which is impossible
    between a number and infinity. NaN if no run sailed.
    """
    late = error_m[:, :, int(np.ceil(from_s(error_m.shape[2] - 1))) :]
    if late[:1].size == 0:
        return np.full((late.shape[0], len(percents)), np.nan)
    pooled = late.reshape(late.shape[0], -1)
    return np.asarray(np.percentile(pooled, percents, axis=1, method="inverted_cdf").T)
