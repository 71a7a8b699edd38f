# SPDX-License-Identifier: MIT
"""Random numbers drawn in advance equal those drawn step by step."""

import numpy as np

from sil.plant.normals import Normals


def test_every_run_has_the_numbers_of_its_own_generator_in_their_order() -> None:
    normals = Normals([np.random.default_rng(seed) for seed in (4, 5)], (2, 3))
    alone = [np.random.default_rng(seed) for seed in (4, 5)]
    for _ in range(300):
        assert (normals.step() == [rng.standard_normal((2, 3)) for rng in alone]).all()


def test_a_run_without_a_generator_has_zeros_and_moves_no_other() -> None:
    normals = Normals([None, np.random.default_rng(5)], (4,))
    alone = np.random.default_rng(5)
    for _ in range(100):
        nothing, drawn = normals.step()
        assert not nothing.any() and (drawn == alone.standard_normal(4)).all()
