# SPDX-License-Identifier: MIT
"""The distances |e| of all boats in all runs, one sample per second."""

from dataclasses import dataclass

import numpy as np

from sil.campaign import late
from sil.campaign.finished import DIVERGED, FAILED, OK, Campaign, columns
from sil.plant.hull import Array


@dataclass(frozen=True)
class Samples:
    """Distances `error_m` (N, R, T) at `t_s` (T) of the R runs that sailed.

    Distances of a diverged run are infinite at all times; failed runs are left out. `ok` (R): the
    runs that did not diverge.
    """

    t_s: Array
    error_m: Array
    ok: Array

    @property
    def late_s(self) -> float:
        """The time from which boats count as in formation, s."""
        return late.from_s(float(self.t_s.max(initial=0.0)))

    def late_percentiles(self, percents: tuple[float, ...]) -> Array:
        """Percentiles (N, len(percents)) over all runs and seconds from `late_s` on."""
        return late.percentiles(self.error_m, percents)


def read(campaign: Campaign) -> Samples:
    """The samples of seconds.parquet; ValueError if they do not fit the campaign's table."""
    table = columns(campaign.folder, "seconds")
    sailed = campaign.runs[campaign.outcome != FAILED]
    row = np.isin(table["run"], sailed)
    t_s = np.unique(table["t_s"][row])
    error_m = np.full((campaign.boats, sailed.size, t_s.size), np.inf, dtype=np.float32)
    run = np.searchsorted(sailed, table["run"][row])
    second = np.searchsorted(t_s, table["t_s"][row])
    distance = table["error_m"][row]
    error_m[table["boat"][row] - 1, run, second] = np.where(np.isnan(distance), np.inf, distance)
    outcome = campaign.outcome[campaign.outcome != FAILED]
    error_m[:, outcome == DIVERGED] = np.inf
    return Samples(t_s, error_m, outcome == OK)
