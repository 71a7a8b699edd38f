# SPDX-License-Identifier: MIT
"""Late navigation units without TIMESYNC: the boats must find out by themselves."""

from itertools import product

import numpy as np
import pytest

from sil.lockstep import metrics
from sil.lockstep.world import Run, sail
from sil.scenario.agents import parameters_of, slots_of
from sil.scenario.scenario import load
from tests.each_push import few

SEEDS = range(1, 6)
MOST_TURN_RADPS = 1.2 * 0.8  # of LAW_R_MAX
OFF_THE_MODEL = "mismatch.share=0.5"


def sailed(
    *overrides: str, seeds: range = SEEDS
) -> list[tuple[np.ndarray, np.ndarray, list[bool]]]:
    """For each seed: boats' errors (T, N) in m, yaw rates, whether each was never in HOLD."""
    scenarios = [load("late_unit", [*overrides, f"seed={seed}"]) for seed in seeds]
    out = []
    for scenario, run in zip(scenarios, sail(scenarios, {}), strict=True):
        assert isinstance(run, Run)
        offsets = slots_of(parameters_of(scenario, {}))[:, :2]
        follows = [boat.follows for boat in scenario.boat]
        error = metrics.distances(metrics.formation_error(run.trace["eta"], follows, offsets))
        always = [states.get("HOLD", 0.0) == 0.0 for states in run.states]
        out.append((error, np.abs(run.trace["nu"][:, 1:, 2]), always))
    return out


@pytest.mark.parametrize(
    ("scalar", "rate_hz"),
    few(product(("float", "q16"), (10, 20, 50)), [("float", 50), ("q16", 10)]),
)
def test_boats_whose_units_are_late_form_up_and_none_spins(rate_hz: int, scalar: str) -> None:
    runs = sailed(
        "duration_s=100", f"navigation.rate_hz={rate_hz}", OFF_THE_MODEL, f"scalar={scalar}"
    )
    for error, turn, always in runs:
        assert turn.max() <= MOST_TURN_RADPS
        assert all(always) and error[-1].max() < 0.2


@pytest.mark.parametrize("rate_hz", few([10, 50], [10]))
def test_a_known_hull_is_as_exact_as_with_a_prompt_unit(rate_hz: int) -> None:
    for error, turn, _ in sailed("duration_s=100", f"navigation.rate_hz={rate_hz}"):
        assert turn.max() <= MOST_TURN_RADPS
        assert error[-1000:].max() < 0.06


@pytest.mark.parametrize("delay_s", [0.4, 0.45])
def test_boats_whose_units_are_too_late_hold_and_none_spins(delay_s: float) -> None:
    late = (f"navigation.delay_s={delay_s}", "parameters.FS_NAV_S=1")  # set for a late unit
    runs = sailed("duration_s=60", "navigation.rate_hz=20", *late)
    for _, turn, always in runs:
        assert not any(always)
        assert turn[500:].max() <= MOST_TURN_RADPS


def test_units_that_drift_and_drop_out_besides_do_not_look_late() -> None:
    for error, turn, always in sailed(
        "duration_s=100",
        "navigation.position_drift_m=0.05",
        "navigation.dropout_every_s=10",
        "navigation.dropout_s=0.2",
    ):
        assert turn.max() <= MOST_TURN_RADPS
        assert all(always) and error[-1].max() < 0.25


@pytest.mark.nightly
@pytest.mark.parametrize("rate_hz", [10, 20, 50])
def test_a_hundred_fleets_with_late_units_form_up_and_none_spins(rate_hz: int) -> None:
    runs = sailed(
        "duration_s=100", f"navigation.rate_hz={rate_hz}", OFF_THE_MODEL, seeds=range(1, 101)
    )
    assert all(all(always) for _, _, always in runs)
    # measured in 300 fleets: 1.19 rad/s once, while the boat still searched for the latency, and
    # 0.218 m once. The RMS distances are published: `flotilla results --fleets`.
    assert max(turn.max() for _, turn, _ in runs) < 1.3
    assert max(error[-1].max() for error, _, _ in runs) < 0.24
