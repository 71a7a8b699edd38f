# SPDX-License-Identifier: MIT
"""The sampled loops' decay, compared with theory or simulation, and the verdicts."""

import numpy as np
import pytest

from sil.certificate import floquet, monodromy, sampled
from sil.certificate.sampled import SampledLoop, quick_decay, sampled_loop, uncontrollable
from sil.report.figures import REFERENCE as NOMINAL_RUN
from sil.scenario.law import Law
from tests.sil.certificate.made_up import AT_REST, SINE, TURN, behind, boat

AT_50_HZ = ("rate_hz=50.0", "navigation.rate_hz=50.0")


def examined(*overrides: str, law: Law = "paper", **changed: float) -> SampledLoop:
    reference, setup = behind(overrides, law, changed, 1)
    return sampled_loop(setup, reference.kind == "rest")[0]


@pytest.fixture(scope="module")
def paper() -> SampledLoop:
    return examined()


def test_error_of_the_continuous_reference_run_decays_as_the_multipliers_say(
    paper: SampledLoop,
) -> None:
    run = np.genfromtxt(NOMINAL_RUN, delimiter=",", names=True)
    distance = np.hypot(run["ex1_m"], run["ey1_m"])
    # whole periods of the error's envelope: 21 s
    seen = np.log(distance[40] / distance[103]) / 63.0
    assert paper.decay == pytest.approx(seen, rel=0.02)
    assert paper.steady and paper.holds and paper.outcome == "converges"


def test_papers_loop_decays_as_its_periodic_system_and_its_heading_as_k_psi(
    paper: SampledLoop,
) -> None:
    reference, setup = behind((), "paper", {}, 1)
    values = floquet.multipliers(setup.hull, reference, [0.2])
    slow = -np.log(np.abs(values[0, :2])) / (2.0 * np.pi / 0.3)
    np.testing.assert_allclose(paper.decays[:3], [*slow, 0.2], rtol=0.005)
    assert paper.radius == pytest.approx(abs(values[0, 0]), rel=0.005)


def test_in_a_constant_turn_the_decay_is_that_of_a_constant_matrix() -> None:
    found = examined(*TURN)
    # eq:26 with v̄_y at its equilibrium: half of k_x
    assert found.decay == pytest.approx(0.1, rel=0.01)


def test_decay_from_few_instants_is_within_1_percent_of_that_from_many(paper: SampledLoop) -> None:
    setup = boat()
    points = sampled_loop(setup, False)[1]
    assert quick_decay(setup, points)[0] == pytest.approx(paper.decay, rel=0.01)


def test_on_a_straight_leg_the_papers_law_leaves_the_error_abeam_and_the_products_does_not() -> (
    None
):
    papers = examined(SINE)
    assert papers.outcome == "stays" and not papers.holds and papers.neutral == 0
    assert papers.radius == pytest.approx(1.0, abs=1e-6)
    assert examined(SINE, law="product").holds


def on_a_straight_leg(current_mps: str, **changed: float) -> SampledLoop:
    return examined(SINE, f"water.current_mps={current_mps}", law="product", **changed)


def test_current_along_a_straight_leg_stays_unknown_without_an_effect_and_all_else_decays() -> None:
    found = on_a_straight_leg("[0.07, 0.07]", LAW_CUR_BW=0.1, LAW_OBS_BW=2.0)
    assert found.holds and found.decay > 0.05
    assert found.misled and found.misled.wrong_mps == pytest.approx(0.099, abs=0.001)
    assert 0.0 < found.misled.off_m < 0.005 and found.misled.thrust_N < 1e-4
    assert not found.misled.limited
    assert on_a_straight_leg("[0.07, 0.07]", LAW_CUR_BW=0.0, LAW_OBS_BW=2.0).misled is None


def test_error_abeam_that_never_decays_is_not_taken_for_the_current(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(monodromy, "_MOST_SAIL_S", 60.0)
    found = on_a_straight_leg("[0.07, 0.07]", LAW_CUR_BW=0.1, LAW_OBS_BW=2.0, LAW_XT_DIST=0.0)
    assert found.outcome == "stays" and not found.holds


def test_estimate_with_an_error_close_to_the_boats_speed_moves_it_far() -> None:
    found = on_a_straight_leg("[0.4, 0.1]", LAW_CUR_BW=0.1, LAW_OBS_BW=2.0)
    assert found.misled and found.misled.off_m > 0.5


@pytest.mark.parametrize("law", ["paper", "product"])
def test_behind_a_leader_at_rest_the_law_is_not_blamed_for_the_error_abeam(law: Law) -> None:
    found = examined(*AT_REST, law=law)
    assert found.neutral == 1
    assert found.holds and found.decay > 0.1


def test_sway_is_controllable_only_with_way_on() -> None:
    for overrides, thrust_N, count in ((AT_REST, 0.0, 1), ((SINE,), 1.0, 0)):
        setup = boat(*overrides)
        state = np.concatenate([setup.slot.eta(np.zeros(1))[0], setup.slot.nu(np.zeros(1))[0]])
        assert uncontrollable(setup, np.append(state, [thrust_N, thrust_N])) == count


def test_yaw_gain_too_high_for_its_rate_grows() -> None:
    found = examined(*AT_50_HZ, LAW_KDR=60.0)
    assert found.outcome == "grows" and not found.holds
    assert found.decay < -10.0 and found.radius > 1e100


def test_limit_of_the_yaw_gain_is_that_of_the_sampled_loop() -> None:
    # ṙ = (N − d33 r)/m33, N = −k_dr r held for h: stable up to (1 + e^{−ah}) d33 / (1 − e^{−ah})
    decay = np.exp(-0.864 / 0.354 * 0.02)
    limit = 0.864 * (1.0 + decay) / (1.0 - decay) - 0.864
    assert examined(*AT_50_HZ, *AT_REST, LAW_KDR=0.98 * limit).outcome == "converges"
    assert examined(*AT_50_HZ, *AT_REST, LAW_KDR=1.04 * limit).outcome == "grows"


def test_boat_at_its_propellers_limits_is_not_steady() -> None:
    found = examined("propellers.forward_max_N=1.2", THR_FWD_MAX=1.2)
    assert found.limited and not found.steady and not found.holds


def test_cross_current_carries_the_papers_boat_off_a_straight_leg() -> None:
    found = examined(SINE, "water.current_mps=[0.0, 0.1]")
    assert not found.steady and not found.holds


def test_modes_of_the_estimates_are_separated_from_those_of_the_law() -> None:
    both = examined(law="product", LAW_CUR_BW=0.05, LAW_OBS_BW=1.0)
    law = examined(law="product", LAW_CUR_BW=0.0, LAW_OBS_BW=0.0)
    assert both.decay < law.decay
    assert set(both.slowest) == {"current north", "current east"}
    assert list(both.slowest.values()) == sorted(both.slowest.values(), reverse=True)
    assert both.decay_of_law == pytest.approx(law.decay, rel=0.02)
    assert sampled.ESTIMATES == ("LAW_CUR_BW", "LAW_OBS_BW")
