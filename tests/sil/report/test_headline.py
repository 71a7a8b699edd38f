# SPDX-License-Identifier: MIT
"""The first line of a run's report."""

from typing import Any, cast

import numpy as np
import pytest

from sil.lockstep.metrics import BoatSummary, Summary
from sil.report import headline


def boat(number: int, **changes: Any) -> BoatSummary:
    told = {
        "id": number,
        "rms_error_m": 0.0001,
        "max_error_m": 0.0002,
        "final_error": {"x_m": 0.0, "y_m": 0.0, "psi_rad": 0.0},
        "settling_time_s": 59.7,
        "thrust_rms_N": 1.0,
        "thrust_step_rms_N": 0.0,
        "states": {"FORMATION": 300.0, "HOLD": 0.0},
    }
    return cast(BoatSummary, told | changes)


def summary(*boats: BoatSummary, separation_m: float | None = 1.18, hull_m: float = 1.0) -> Summary:
    return {
        "scenario": "pair",
        "seed": 1,
        "duration_s": 300.0,
        "wall_s": 1.0,
        "real_time_factor": 300.0,
        "digest": None,
        "release_unix_s": None,
        "late_s": None,
        "boats": list(boats),
        "min_separation_m": separation_m,
        "hull_m": hull_m,
    }


def test_headline_of_a_good_run_has_settling_time_error_and_separation() -> None:
    found = headline.of_run(summary(boat(1, settling_time_s=12.0), boat(2)))
    assert found.level == "good"
    settled = (
        "2 of 2 stay within 0.05 m of their slots from 60 s on; worst 0.2 mm in the last third"
    )
    assert found.text == f"{settled}; closest two boats 1.18 m"


def test_single_boat_has_no_neighbour() -> None:
    found = headline.of_run(summary(boat(1), separation_m=None))
    assert found.level == "good"
    settled = "1 of 1 stay within 0.05 m of their slots from 60 s on"
    assert found.text == f"{settled}; worst 0.2 mm in the last third"


def test_boats_that_settle_late_are_judged_by_their_errors_in_the_last_third() -> None:
    late = boat(2, settling_time_s=290.0, max_error_m=0.14)
    found = headline.of_run(summary(boat(1), late))
    assert found.level == "good"
    assert found.text.startswith("2 of 2 stay within 0.2 m of their slots; worst 0.14 m in the")


def test_boat_that_does_not_stay_in_its_slot_is_counted_out() -> None:
    found = headline.of_run(summary(boat(1), boat(2, settling_time_s=None, max_error_m=0.213)))
    assert found.level == "fair"
    assert found.text.startswith("1 of 2 stay within 0.2 m of their slots; worst 0.21 m")


def test_a_boat_that_measures_its_hull_is_judged_by_its_voyage_not_by_a_slot() -> None:
    alone = boat(1, settling_time_s=None, max_error_m=49.3, states={"AUTO": 300.0})
    told = summary(alone, separation_m=None)
    told["voyage"] = "Voyage: over, 42 of 42 steps complete"
    assert headline.of_run(told) == ("good", "Voyage: over, 42 of 42 steps complete")
    told["voyage"] = ""
    assert headline.of_run(told) == ("fair", "the voyage was not over after 300 s")
    alone["states"] = {"AUTO": 200.0, "HOLD": 100.0}
    assert headline.of_run(told).level == "bad"


def test_a_run_by_a_plan_is_good_only_once_the_plan_is_over() -> None:
    told = summary(boat(1), boat(2))
    told["plan"] = {"item": 4, "items": 6, "over_s": None, "waiting_m": None}
    found = headline.of_run(told)
    assert found.level == "fair"
    assert found.text.endswith("; boat 1's plan was not over: still on item 4 of 6")
    told["plan"] = {"item": 6, "items": 6, "over_s": 242.3, "waiting_m": 0.412}
    found = headline.of_run(told)
    assert found.level == "good"
    over = "; boat 1's plan was over after 242 s, then all waited within 0.41 m"
    assert found.text.endswith(over)


def test_a_boat_that_settles_in_the_last_third_of_a_plan_settles_late() -> None:
    told = summary(boat(1, settling_time_s=150.0))
    assert "within 0.05 m of their slots from 150 s on" in headline.of_run(told).text
    told["plan"] = {"item": 6, "items": 6, "over_s": 200.0, "waiting_m": 0.1}
    assert "within 0.2 m of their slots; worst" in headline.of_run(told).text


@pytest.mark.parametrize(
    ("least_m", "hull_m", "level"), [(1.18, 1.0, "good"), (1.18, 2.0, "bad"), (np.nan, 1.0, "bad")]
)
def test_boats_nearer_than_a_hull_is_long_are_bad(
    least_m: float, hull_m: float, level: str
) -> None:
    found = headline.of_run(summary(boat(1), boat(2), separation_m=least_m, hull_m=hull_m))
    assert found.level == level
    assert ("nearer than a hull's length" in found.text) == (level == "bad")


def test_boat_that_left_formation_is_bad_and_one_that_coasted_is_not() -> None:
    coasted = boat(1, states={"FORMATION": 295.0, "COAST": 5.0})
    held = boat(2, states={"FORMATION": 280.0, "HOLD": 20.0})
    assert headline.of_run(summary(coasted)).level == "good"
    found = headline.of_run(summary(coasted, held))
    assert found.level == "bad"
    assert found.text.endswith("; boat 2 was 20.0 s in HOLD")


@pytest.mark.parametrize("lost", [np.nan, np.inf])
def test_boat_without_a_finite_error_is_bad(lost: float) -> None:
    found = headline.of_run(summary(boat(1), boat(2, settling_time_s=None, max_error_m=lost)))
    assert found.level == "bad"
    assert found.text.endswith("; boat 2 has no finite error")


def test_campaign_headline_counts_how_its_runs_ended() -> None:
    good = headline.Ended(runs=20, settled=20, near=0, diverged=0, failed=0, hull_m=1.0)
    assert headline.of_campaign(good) == (
        "good",
        "20 of 20 runs settled; in none did two boats come nearer than a hull's length (1 m); "
        "none diverged; none failed",
    )
    assert headline.of_campaign(good._replace(settled=19)).level == "fair"
    for count in ("near", "diverged", "failed"):
        assert headline.of_campaign(good._replace(**{count: 1})).level == "bad"
    assert "nearer" not in headline.of_campaign(good._replace(near=None)).text
