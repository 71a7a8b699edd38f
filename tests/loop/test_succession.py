# SPDX-License-Identifier: MIT
"""Eight boats lose their leader, an inner boat, or half of their radio, and sail on."""

from itertools import product

import flotilla
import numpy as np
import pytest

from sil.lockstep.world import sail as sail_runs
from tests.loop import succession
from tests.loop.succession import KINDS, NOTHING, Healed, Observer, sail, scenarios_of

AT_S = 33.0, 41.3, 62.0


@pytest.fixture(
    scope="module",
    params=[
        pytest.param(case, marks=() if case[1] == AT_S[0] else pytest.mark.nightly)
        for case in product(KINDS, AT_S)
    ],
    ids=str,
)
def healed(request: pytest.FixtureRequest) -> Healed:
    kind, at_s = request.param
    (it,) = sail(kind, [at_s])
    return it


@pytest.fixture(scope="module")
def undisturbed() -> Healed:
    (it,) = sail(NOTHING, AT_S[1:2])
    return it


def test_one_boat_leads_within_three_seconds(healed: Healed) -> None:
    assert healed.leads_s <= 3.0 and healed.two_s <= 2.0


def test_the_mission_goes_on(healed: Healed) -> None:
    assert healed.goes_on


def test_one_leads_and_all_others_follow_it(healed: Healed) -> None:
    assert set(healed.states) == {"AUTO", "FORMATION"}
    assert healed.states.count("AUTO") == 1


def test_no_two_boats_come_near(healed: Healed) -> None:
    assert healed.nearest_m >= 0.8 * 1.44  # of FS_SEP_M


def test_all_are_in_their_slots_after_a_minute(healed: Healed, undisturbed: Healed) -> None:
    assert healed.slots_s <= 60.0
    # later, in the plan's corners, no farther off than a fleet that has lost nothing
    assert healed.off_m <= max(0.2, undisturbed.off_m)


def test_boats_coast_shortly_behind_new_leaders() -> None:
    """Six fleets get their table after 3 s, and with it five boats another leader."""
    instants = [10.0] * 6
    runs = [
        one.model_copy(update={"duration_s": 15.0, "fault": ()})
        for one in scenarios_of("leader", instants)
    ]
    observer = Observer("leader", instants, runs[0])
    sail_runs(runs, {}, keep_s=1.0, watch=observer)
    states = np.array([track.states for track in observer.tracks])
    coasts = states == flotilla.STATES.index("COAST")
    step_s = observer.tracks[0].t_s[1] - observer.tracks[0].t_s[0]
    mean_s = float(coasts.sum()) * step_s / coasts[:, 0].size
    print(f"in COAST: {mean_s:.2f} s a boat")
    assert 0.1 < mean_s < 0.85
    assert (states[:, -1] != flotilla.STATES.index("HOLD")).all()


def test_after_the_plans_end_the_next_leader_waits_and_does_not_sail_it_again(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    settings = ("leader.waypoints=[[0, 0], [12, 0]]", *succession.SETTINGS[1:])
    monkeypatch.setattr(succession, "SETTINGS", settings)
    (it,) = sail("leader", [80.0])
    assert it.leads_s <= 3.0
    assert it.states.count("LOITER") == 1 and set(it.states) == {"LOITER", "FORMATION"}


def test_a_boat_that_takes_over_from_a_paused_leader_waits() -> None:
    (it,) = sail("paused", AT_S[1:2])
    assert it.leads_s <= 3.0
    assert it.states.count("LOITER") == 1 and set(it.states) == {"LOITER", "FORMATION"}


def test_a_boat_that_a_new_table_leaves_out_stops_and_the_others_sail_on() -> None:
    (it,) = sail("left_out", AT_S[1:2])
    assert it.gone == ("HOLD",)
    assert it.goes_on and it.states.count("FORMATION") == 6


def test_a_leader_that_restarts_stays_disarmed(healed: Healed) -> None:
    assert healed.kind != "restart" or healed.gone == ("DISARMED",)
