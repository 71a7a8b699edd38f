# SPDX-License-Identifier: MIT
"""The sampled loop of a boat: equals the boat's, its state can be set, copies are independent."""

import numpy as np
import pytest

from sil.certificate.loop import COMPONENTS, Loop, _Curve, leader_rows
from sil.lockstep.world import World
from sil.plant.hull import Array
from sil.scenario.scenario import load
from tests.sil.certificate.made_up import TURN, boat, reference


def sail(loop: Loop, ticks: int) -> None:
    times_s = loop.boat.h_s * np.arange(loop.tick, loop.tick + ticks, dtype=np.float64)
    for row in leader_rows(loop.boat.leader, times_s):
        loop.step(row)


def test_boat_sails_as_its_firmware_does_on_the_wire(
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    leader = "leader.nu=[0.582, 0.0, 0.0]"
    start = [leader, "boat.1.eta=[0.3, -0.2, 0.1]", "duration_s=8.0", 'scalar="double"']
    scenario = load("diamond", [*start, "boat.1.propellers.lag_s=0.1"], "paper")
    recording = tmp_path_factory.mktemp("loop") / "recording.bin"
    trace = World(scenario, {}).run(recording, lambda _: None).trace

    loop = Loop(boat(*start, "boat.1.propellers.lag_s=0.1"), 1)
    loop.start(0)
    loop.eta[:], loop.nu[:] = trace["eta"][0, 1], trace["nu"][0, 1]
    leader_eta, leader_nu = trace["eta"][:, 0], trace["nu"][:, 0]
    rate = np.gradient(leader_nu, 0.01, axis=0)
    poses = []
    for row in np.hstack([leader_eta, leader_nu, rate]):
        poses.append(loop.eta[0].copy())
        loop.step(row)
    # the wire rounds, and the follower must estimate its leader's acceleration
    np.testing.assert_allclose(np.array(poses), trace["eta"][:, 1], atol=5e-3)


def test_loop_goes_on_from_a_state_as_if_it_had_never_stopped() -> None:
    boat_1 = boat("navigation.rate_hz=25.0", law="product")
    straight_on, stopped = Loop(boat_1, 1), Loop(boat_1, 2)
    straight_on.start(1000)
    sail(straight_on, 40)
    state = straight_on.state
    sail(straight_on, 40)
    stopped.resume(1040, np.repeat(state, 2, axis=0))
    sail(stopped, 40)
    np.testing.assert_allclose(stopped.state[0], straight_on.state[0], atol=1e-9)
    assert stopped.state[0].tobytes() == stopped.state[1].tobytes()


def test_every_component_of_the_state_has_a_name() -> None:
    loop = Loop(boat(), 1)
    assert loop.state.shape == (1, len(COMPONENTS)) and len(set(COMPONENTS)) == len(COMPONENTS)
    loop.start(0)
    sail(loop, 300)
    known = dict(zip(COMPONENTS, loop.state[0], strict=True))
    assert known["u known"] == pytest.approx(known["u"], abs=1e-3)
    force = known["thrust port"] + known["thrust stbd"]
    assert known["given X"] == pytest.approx(force, abs=1e-6) and force > 1.0


def test_copies_do_not_disturb_each_other() -> None:
    loop = Loop(boat(), 2)
    loop.start(500)
    sail(loop, 20)
    state = loop.state
    state[1, 0] += 0.5
    loop.resume(520, state)
    sail(loop, 50)
    alone = Loop(boat(), 1)
    alone.resume(520, state[:1])
    sail(alone, 50)
    np.testing.assert_array_equal(loop.state[0], alone.state[0])
    assert abs(loop.state[1, 0] - loop.state[0, 0]) > 0.1


@pytest.mark.parametrize(("rate_hz", "cycle"), [(100.0, 1), (20.0, 5), (30.0, 10), (5.0, 20)])
def test_fixes_come_as_often_as_the_navigation_unit_sends_them(rate_hz: float, cycle: int) -> None:
    loop = boat(f"navigation.rate_hz={rate_hz}")
    due = [loop.fix_due(tick) for tick in range(1000)]
    assert sum(due) == pytest.approx(10 * rate_hz, abs=1)
    assert loop.cycle == cycle
    assert due[: 1000 - cycle] == due[cycle:]


@pytest.mark.parametrize("expo", [0.0, 0.6, 1.0])
def test_propeller_with_a_known_curve_gives_the_thrust_requested(expo: float) -> None:
    changed = [*TURN, f"propellers.expo={expo}"]
    loop = Loop(boat(*changed, changed={"THR_EXPO": expo}), 1)
    loop.start(0)
    sail(loop, 800)
    np.testing.assert_allclose(loop.thrust, [[1.3, 0.7]], atol=0.02)
    slot: Array = reference(*TURN).motion.eta(np.array([8.0]))
    np.testing.assert_allclose(loop.eta, slot, atol=1e-3)


def test_no_thrust_needs_no_command_on_a_quadratic_curve() -> None:
    limits = {"THR_FWD_MAX": 4.0, "THR_REV_MAX": 4.0, "THR_BALANCE": 0.0, "THR_EXPO": 1.0}
    with np.errstate(all="raise"):
        assert _Curve.of(limits)(np.array([0.0, 1.0])).tolist() == [0.0, 0.5]


def test_thrust_beyond_the_propellers_is_reported_as_limited() -> None:
    loop = Loop(boat(changed={"THR_FWD_MAX": 1.0}), 1)
    loop.start(0)
    sail(loop, 1)
    assert loop.limited
    free = Loop(boat(), 1)
    free.start(0)
    sail(free, 100)
    assert not free.limited
