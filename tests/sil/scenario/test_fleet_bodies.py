# SPDX-License-Identifier: MIT
"""The plant of a scenario: hulls, current, random numbers."""

import numpy as np
import pytest

from sil.plant.bodies import Bodies
from sil.plant.hull import Array
from sil.scenario import scenario
from sil.scenario.fleet_bodies import bodies_of, hulls_of
from sil.scenario.streams import Stream, generator

TICKS = 200
WEATHER = ["white_noise.power=0.1", "wind.gust_mps=0.5", "waves.height_m=0.1"]
OTTER = ["vessel.length_m=2", "vessel.draft_m=0.2", "vessel.frontal_m2=1", "vessel.wind_x=1"]


def drift(bodies: Bodies) -> Array:
    """Velocities (TICKS, A, 3) of bodies without thrust."""
    nu = np.empty((TICKS, *bodies.nu.shape))
    for k in range(TICKS):
        bodies.advance(np.zeros((len(bodies.rpm), 2)), np.zeros((3, 1, 2)), 0.01)
        nu[k] = bodies.nu
    return nu


def diamond(*overrides: str) -> scenario.Scenario:
    return scenario.load("diamond", overrides)


def test_boats_of_diamond_have_the_papers_hull_in_still_water() -> None:
    nu = drift(bodies_of([diamond()]))
    assert len(set(hulls_of(diamond()))) == 1
    assert (nu == 0.0).all()


def test_mismatch_is_the_boats_and_never_the_references_nor_the_firmwares() -> None:
    apart = diamond("mismatch.share=0.5")
    nominal = diamond().hulls()[0]
    reference, *boats = hulls_of(apart)
    assert reference == nominal
    assert len(set(boats)) == 4 and nominal not in boats
    assert apart.hulls() == [nominal] * 5
    assert apart.firmware_parameters(apart.boat[0]) == diamond().firmware_parameters(apart.boat[0])


def test_mismatch_repeats_with_its_seed_and_grows_with_its_share() -> None:
    half, again = (hulls_of(diamond("mismatch.share=0.5", "seed=4")) for _ in range(2))
    assert half == again
    assert half != hulls_of(diamond("mismatch.share=0.5", "seed=5"))
    tenth = hulls_of(diamond("mismatch.share=0.1", "seed=4"))
    off = [hull.m11 / 1.012 - 1.0 for hull in half[1:]]
    assert [hull.m11 / 1.012 - 1.0 for hull in tenth[1:]] == pytest.approx([0.2 * o for o in off])


def test_draws_from_one_random_stream_do_not_change_another() -> None:
    calm = drift(bodies_of([diamond("white_noise.power=0.1")]))
    assert np.ptp(calm[:, 1:]) > 0.0
    same_hulls = diamond("white_noise.power=0.1", "mismatch.share=1e-300")
    np.testing.assert_allclose(drift(bodies_of([same_hulls])), calm, atol=1e-12)
    with_calm_sea = diamond("white_noise.power=0.1", "wind.gust_mps=1e-300", "waves.height_m=1e-9")
    np.testing.assert_allclose(drift(bodies_of([with_calm_sea])), calm, atol=1e-6)


def test_streams_are_the_children_of_the_seed_and_differ() -> None:
    children = np.random.SeedSequence(7).spawn(len(Stream))
    for stream, child in zip(Stream, children, strict=True):
        expected = np.random.default_rng(child).random(4)
        assert (generator(7, stream).random(4) == expected).all()
    assert len({generator(7, stream).random() for stream in Stream}) == len(Stream)


@pytest.mark.parametrize("cause", [*WEATHER, "wind.mean_mps=[2, 1]", "water.current_mps=[0.1, 0]"])
def test_each_cause_moves_the_boats_and_not_the_virtual_leader(cause: str) -> None:
    nu = drift(bodies_of([diamond(cause, *OTTER)]))
    assert (nu[:, 0] == 0.0).all()
    assert (np.abs(nu[:, 1:]).max(axis=(0, 2)) > 1e-4).all()
    again = drift(bodies_of([diamond(cause, *OTTER)]))
    assert (nu == again).all()


def test_boats_adrift_end_up_with_the_water() -> None:
    bodies = bodies_of([diamond("water.current_mps=[0.1, -0.2]")])
    for _ in range(20):
        nu = drift(bodies)[-1]
    psi = bodies.eta[1:, 2]
    north = np.cos(psi) * nu[1:, 0] - np.sin(psi) * nu[1:, 1]
    east = np.sin(psi) * nu[1:, 0] + np.cos(psi) * nu[1:, 1]
    np.testing.assert_allclose(north, 0.1, atol=1e-3)
    np.testing.assert_allclose(east, -0.2, atol=1e-3)


def test_boats_drift_the_same_bits_alone_and_in_a_batch_of_other_weathers() -> None:
    causes = [*WEATHER, "wind.mean_mps=[2, 1]", "water.current_mps=[0.1, 0]", "mismatch.share=0.5"]
    batch = [diamond(*OTTER, f"seed={k}", *causes[: k + 1]) for k in range(len(causes))]
    batch += [diamond(*OTTER, cause) for cause in causes]
    together = drift(bodies_of(batch))[:, len(batch) :].reshape(TICKS, len(batch), 4, 3)
    for run, chosen in enumerate(batch):
        alone = drift(bodies_of([chosen]))[:, 1:]
        assert together[:, run].tobytes() == alone.tobytes(), run
