# SPDX-License-Identifier: MIT
"""Scenarios in which boat 1 leads, and the clock of their plan."""

from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from sil.lockstep.start import StartError
from sil.lockstep.world import Run, all_sailed, sail
from sil.scenario.agents import parameters_of
from sil.scenario.scenario import ScenarioError, load
from sil.scenario.told_plan import items_of
from sil.scenario.wiring import WORLD

FAST = ["leader.waypoints=[[0, 0], [15, 0], [15, 15]]", "duration_s=40"]
EXACT = [
    "navigation.position_noise_m=0",
    "navigation.position_drift_m=0",
    "navigation.heading_noise_rad=0",
    "navigation.velocity_noise_mps=0",
    "navigation.yaw_rate_noise_radps=0",
    "water.current_mps=[0, 0]",
    "propellers.stbd_gain=1",
]


def sailed(*overrides: str) -> Run:
    (run,) = all_sailed(sail([load("lead", [*FAST, *overrides])], {}))
    return run


def test_boat_1_leads_all_others_and_follows_none_of_them() -> None:
    one = load("lead")
    assert one.pairs() == [(1, 2), (1, 3), (1, 4)]
    leaders = [own["FORM_LEADER"] for own in parameters_of(one, {})]
    assert leaders == [100, 1, 1, 1]
    assert one.boat[0].offset_m == (0.0, 0.0)


def test_the_plan_is_the_waypoints_without_the_start() -> None:
    speed, *points = items_of(load("lead", FAST).leader)
    assert (speed.command, speed.params[1]) == (mavlink.MAV_CMD_DO_CHANGE_SPEED, 0.6)
    places = [tuple(WORLD.geodetic(15.0, east, 0.0)[:2]) for east in (0.0, 15.0)]
    assert [(point.latitude, point.longitude) for point in points] == places
    assert all(point.command == mavlink.MAV_CMD_NAV_WAYPOINT for point in points)


def test_corner_radius_and_turning_slots_become_the_boats_width() -> None:
    wide = load("lead", [*FAST, "leader.corner_radius_m=5.0"])
    assert parameters_of(wide, {})[0]["WP_WIDTH"] == pytest.approx(4.0)
    assert all(item.params[1] == 100.0 for item in items_of(wide.leader)[1:])
    motion = wide.route()
    turning = np.abs(motion[:, 5]) > 1e-6
    assert (np.abs(motion[turning, 3] / motion[turning, 5])).min() == pytest.approx(5.0, rel=0.01)


def test_without_errors_the_boat_is_where_the_planner_alone_says() -> None:
    """The reference in the trace comes from the planner in double, the boat's own is in float."""
    run = sailed(*EXACT)
    assert [set(states) for states in run.states] == [{"AUTO"}, *[{"FORMATION"}] * 3]
    t_s, eta = run.trace["t_s"], run.trace["eta"]
    late = t_s > 15.0
    assert np.hypot(*run.trace["error"][late, 0, :2].T).max() < 0.06  # of the law, in the corner
    assert eta[-1, 0, 1] > 3.0  # past the corner
    speed = np.hypot(*np.diff(eta[:, 0, :2], axis=0).T) / (t_s[1] - t_s[0])
    assert speed[t_s[1:] > 10.0].max() == pytest.approx(0.6, rel=0.02)
    assert np.abs(np.diff(speed)).max() < 0.02  # no jumps when the boat tells its time


def test_the_plan_waits_while_the_boat_that_leads_is_in_hold() -> None:
    fault = 'fault=[{kind="own_silent", agent=1, at_s=20.0}]'
    run = sailed(fault)
    eta = run.trace["eta"][:, 0, :2]
    assert set(run.states[0]) == {"AUTO", "HOLD"}
    assert np.hypot(*(eta[-1] - eta[-1500])) < 0.01 < np.hypot(*(eta[1000] - eta[0]))


def test_runs_repeat_bit_for_bit_alone_or_together() -> None:
    one = load("lead", FAST)
    other = load("lead", [*FAST, "seed=2"])
    alone = sail([one], {}, digest=True)[0]
    both = sail([one, other], {}, digest=True)
    assert isinstance(alone, Run) and isinstance(both[0], Run) and isinstance(both[1], Run)
    assert alone.digest == both[0].digest != both[1].digest


def test_a_plan_that_the_boat_refuses_ends_the_run_with_its_reason() -> None:
    one = load("lead", [*FAST, "leader.speed_mps=6.0"])
    (error,) = sail([one], {})
    assert isinstance(error, StartError)
    assert "the plan: MAV_MISSION_INVALID_PARAM2" in str(error)


@pytest.mark.parametrize(
    ("overrides", "told"),
    [
        (["leader.boat=2"], '"leader.boat"'),
        (["boat.1.offset_m=[1.0, 0.0]"], "must be [0, 0], as this boat sails the plan itself"),
        (["leader.navigation.rate_hz=5.0"], "boat 1 leads, set [boat.1.navigation] instead"),
        (['fault=[{kind="clock", agent=0, at_s=1.0, value=1.0}]'], "there is no agent 0"),
    ],
)
def test_contradictions_are_reported(overrides: list[str], told: str) -> None:
    with pytest.raises(ScenarioError, match=r"leader|offset|agent") as caught:
        load("lead", overrides)
    assert told in str(caught.value)


def test_a_boat_cannot_lead_without_waypoints(tmp_path: Path) -> None:
    path = tmp_path / "lost.toml"
    path.write_text('base = "diamond"\nduration_s = 10.0\n[leader]\nboat = 1\n', encoding="utf-8")
    with pytest.raises(ScenarioError, match=r'needs "leader.waypoints"'):
        load(path)
