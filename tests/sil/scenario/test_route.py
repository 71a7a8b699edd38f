# SPDX-License-Identifier: MIT
"""Leaders along waypoints and boats by the shape of their formation."""

import math
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from sil.lockstep import metrics
from sil.lockstep.world import Run, sail
from sil.scenario.formation import Formation, Shape, slots
from sil.scenario.route import half_width_m, route, sharpest
from sil.scenario.scenario import Scenario, ScenarioError, load

SQUARE = """\
duration_s = 100.0
[leader]
waypoints = [[0, 0], [20, 0], [20, 20]]
speed_mps = 0.5
[formation]
shape = "line"
boats = 3
spacing_m = 2.0
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "square.toml"
    path.write_text(text, encoding="utf-8")
    return path


def complaint(folder: Path, text: str, *overrides: str) -> str:
    with pytest.raises(ScenarioError) as caught:
        load(written(folder, text), overrides)
    return str(caught.value).replace(f"{folder}/", "")


def motion_of(scenario: Scenario) -> np.ndarray:
    return route(scenario.leader, scenario.boat, scenario.step_s, scenario.ticks)


@pytest.mark.parametrize(
    ("shape", "boats"),
    [("line", 5), ("column", 4), ("vee", 6), ("diamond", 9), ("circle", 7), ("grid", 7)],
)
def test_neighbours_are_as_far_apart_as_asked(shape: Shape, boats: int) -> None:
    places = slots(Formation(shape=shape, boats=boats, spacing_m=3.0))
    apart = [math.dist(a, b) for a, b in combinations(places, 2)]
    assert len(places) == boats
    assert min(apart) == pytest.approx(3.0)


def test_boats_begin_at_rest_in_their_slots(tmp_path: Path) -> None:
    text = SQUARE.replace("[[0, 0], [20, 0], [20, 20]]", "[[5, 5], [5, 25], [25, 25]]")
    scenario = load(written(tmp_path, text))
    assert scenario.leader.eta == pytest.approx((5.0, 5.0, math.pi / 2))
    # Its bow is to the east: starboard is south.
    assert [boat.offset_m for boat in scenario.boat] == [(0.0, -2.0), (0.0, 0.0), (0.0, 2.0)]
    assert [boat.eta[0] for boat in scenario.boat] == pytest.approx([7.0, 5.0, 3.0])
    assert [boat.eta[1] for boat in scenario.boat] == pytest.approx([5.0, 5.0, 5.0])
    assert {boat.parameters["FORM_FRAME"] for boat in scenario.boat} == {1.0}


def test_slots_that_do_not_turn_are_north_and_east(tmp_path: Path) -> None:
    text = SQUARE.replace("[[0, 0], [20, 0], [20, 20]]", "[[5, 5], [5, 25], [25, 25]]")
    scenario = load(written(tmp_path, text + "turns = false\n"))
    assert [boat.offset_m[0] for boat in scenario.boat] == pytest.approx([2.0, 0.0, -2.0])
    assert all(not boat.parameters for boat in scenario.boat)


def test_a_single_boat_may_differ(tmp_path: Path) -> None:
    own = "[boat.2]\neta = [-4, 1, 0.5]\n[boat.2.parameters]\nLAW_KX = 0.3\n"
    scenario = load(written(tmp_path, SQUARE + own), ["boat.3.offset_m=[1, 2]"])
    assert scenario.boat[1].eta == (-4.0, 1.0, 0.5)
    assert scenario.boat[1].parameters == {"FORM_FRAME": 1.0, "LAW_KX": 0.3}
    assert scenario.boat[2].offset_m == (1.0, 2.0)


def test_overrides_change_route_and_shape_before_they_change_boats() -> None:
    overrides = ["formation.spacing_m=4", "leader.speed_mps=0.4", "boat.1.eta=[0, 0, 0]"]
    scenario = load("square", overrides)
    assert scenario.boat[1].offset_m == (0.0, -4.0)
    assert scenario.boat[0].eta == (0.0, 0.0, 0.0)
    assert motion_of(scenario)[:, 3].max() == pytest.approx(0.4)


def test_waypoints_take_the_place_of_the_input_of_a_base(tmp_path: Path) -> None:
    text = 'base = "diamond"\n[leader]\nwaypoints = [[0, 0], [20, 0]]\n'
    scenario = load(written(tmp_path, text))
    assert scenario.leader.input == ()
    assert scenario.leader.eta == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("was", "now", "said"),
    [
        ("[20, 0], [20, 20]]", "]", '"leader.waypoints": must have at least two points'),
        ("[20, 0],", "[0.05, 0],", "waypoint 2 is less than 0.1 m from the one before"),
        (
            "speed_mps = 0.5",
            "eta = [0, 0, 0]",
            '"leader.eta": "leader.waypoints" determines it, leave one of them out',
        ),
        ('"line"', '"row"', "'diamond', 'circle' or 'grid'"),
        ('"line"', '"diamond"', "a diamond has 1, 4, 9, 16 … boats: use 1 or 4 instead of 3"),
        ("boats = 3", "", 'missing key "formation.boats"'),
        ("spacing_m = 2.0", "spacing_m = 30.0", "the corner at waypoint 2 has a radius of"),
        (
            "spacing_m = 2.0",
            "spacing_m = 2.0\n[boat.4]\nfollows = 0",
            '"boat.4": the number must be from 1 to 3',
        ),
        (
            "spacing_m = 2.0",
            "spacing_m = 2.0\n[[boat]]\nfollows = 0",
            '"boat": [formation] creates the boats; use [boat.2] to change one',
        ),
    ],
)
def test_mistakes_are_reported_with_their_place(
    tmp_path: Path, was: str, now: str, said: str
) -> None:
    assert was in SQUARE
    told = complaint(tmp_path, SQUARE.replace(was, now))
    assert told.startswith("square.toml:")
    assert said in told


def test_a_formation_given_to_a_file_that_lists_its_boats_is_refused_with_a_remedy() -> None:
    remedy = r'"formation": the file lists its boats in \[\[boat\]\]: change those'
    with pytest.raises(ScenarioError, match=remedy):
        load("diamond", ["formation.boats=6"])


def test_a_slot_that_a_corner_swings_out_too_fast_is_refused(tmp_path: Path) -> None:
    column = SQUARE.replace('"line"', '"column"').replace("spacing_m = 2.0", "spacing_m = 9.0")
    told = complaint(tmp_path, column, "leader.corner_radius_m=3")
    assert "at waypoint 2 the slot of boat " in told
    assert "more than its LAW_U_MAX, 1.5 m/s: make corner_radius_m greater" in told
    load(written(tmp_path, column), ["leader.corner_radius_m=3", "formation.turns=false"])
    load(written(tmp_path, column), ["leader.corner_radius_m=3", "law=paper"])


def test_a_column_sails_round_corners_at_the_defaults(tmp_path: Path) -> None:
    text = (
        SQUARE.replace('"line"', '"column"').replace("20", "60").replace("boats = 3", "boats = 5")
    )
    column = load(
        written(tmp_path, text.replace("spacing_m = 2.0", "spacing_m = 4.0")), ["duration_s=300"]
    )
    (run,) = sail([column], {})
    assert isinstance(run, Run)
    assert metrics.distances(run.trace["error"])[-1].max() < 0.1


def test_the_route_keeps_its_limits_and_ends_at_the_last_waypoint() -> None:
    scenario = load("square", ["duration_s=500"])
    motion = motion_of(scenario)
    assert len(motion) == scenario.ticks + 1
    assert np.abs(motion[:, 5]).max() <= 0.35
    assert motion[:, 3].max() == pytest.approx(0.6)
    assert motion[-1, :2] == pytest.approx([0.0, 0.0], abs=1e-9)
    # Slots that turn with the leader: the outermost one is no faster than the leader on a leg.
    assert half_width_m(scenario.boat) == 6.0
    assert (motion[:, 3] + 6.0 * np.abs(motion[:, 5])).max() <= 0.601
    curvature, number = sharpest(motion)
    assert 1.0 / curvature == pytest.approx(15.0, abs=0.1)
    assert number in (2, 3, 4)


@pytest.fixture(scope="module")
def square() -> Run:
    (run,) = sail([load("square")], {})
    assert isinstance(run, Run)
    return run


def test_five_boats_abreast_keep_their_slots_around_the_square(square: Run) -> None:
    error = np.linalg.norm(square.trace["error"][square.trace["t_s"] > 30.0, :, :2], axis=2)
    assert np.sqrt(np.mean(np.square(error), axis=0)).max() < 0.07
    assert error.max() < 0.25


def test_the_boats_stay_in_formation_despite_the_bad_radio(square: Run) -> None:
    for seconds in square.states:
        assert seconds["FORMATION"] > 0.95 * sum(seconds.values())


def test_the_leader_is_where_its_route_is(square: Run) -> None:
    motion = motion_of(load("square"))
    assert square.trace["eta"][:, 0] == pytest.approx(motion[:-1, :3], abs=1e-12)
    assert square.trace["nu"][1:, 0] == pytest.approx(motion[1:-1, 3:6], abs=1e-12)
