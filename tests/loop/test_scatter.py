# SPDX-License-Identifier: MIT
"""Boats with scattered starts keep clear of each other and form up.

The short form of `flotilla campaign scatter --runs 1000`.
"""

import numpy as np
import pytest

from sil.campaign.run_outcome import result_of
from sil.campaign.sampling import Sampler
from sil.lockstep.world import sail
from sil.scenario import scenario

LEAST_M = 1.5


def closest_and_last_errors(
    runs: int, duration_s: int, *overrides: str
) -> tuple[list[float], list[float]]:
    sampler = Sampler(scenario.read("scatter", [f"duration_s={duration_s}", *overrides]))
    scenarios = [sampler.scenario(run) for run in range(runs)]
    together = zip(range(runs), scenarios, sail(scenarios, {}), strict=True)
    results = [result_of(*each) for each in together]
    closest = [result.min_separation_m or 0.0 for result in results]
    return closest, [float(result.error_m[:, -1].max()) for result in results]


# on each push only the first six, 15 % of the runs
@pytest.mark.parametrize("runs", [6, pytest.param(40, marks=pytest.mark.nightly)])
def test_boats_that_start_scattered_never_come_too_near_and_all_arrive(runs: int) -> None:
    closest_m, last_m = closest_and_last_errors(runs, 100)
    assert min(closest_m) > LEAST_M
    assert max(last_m) < 0.02  # measured: 0.007, the last boat after 80 s


def test_boats_that_keep_clear_of_nobody_do_come_too_near() -> None:
    closest_m, _ = closest_and_last_errors(12, 20, "parameters.FS_SEP_M=0")
    assert np.mean(np.array(closest_m) < LEAST_M) >= 0.4


def test_boats_that_send_two_states_a_second_never_come_too_near() -> None:
    slow = ("parameters.SR_STATE=2", "parameters.FS_LEADER_S=3")
    closest_m, _ = closest_and_last_errors(12, 30, *slow)
    assert min(closest_m) > LEAST_M
