# SPDX-License-Identifier: MIT
"""The README's animation agrees with the trace."""

import io

import numpy as np
import pytest
from PIL import Image, ImageSequence

from sil.lockstep import metrics
from sil.results import results_film


@pytest.mark.parametrize("psi", [0.0, 0.7, -2.0])
def test_a_slot_is_where_the_formation_error_says(psi: float) -> None:
    eta = np.array([[[5.0, 7.0, 0.3], [1.0, 2.0, psi]]])
    error = metrics.formation_error(eta, [0], np.array([[-2.0, 3.0]]), [False])
    assert results_film.slots(eta[0, 1:], error[0]) == pytest.approx(np.array([[3.0, 10.0]]))


def test_a_film_has_a_frame_every_half_second_and_waits_at_its_end() -> None:
    t_s = np.arange(0.0, 1.01, 0.01)
    eta = np.zeros((t_s.size, 3, 3))
    eta[:, :, 0] = t_s[:, None] + np.array([0.0, 2.0, 4.0])
    trace = {"t_s": t_s, "eta": eta, "error": np.ones((t_s.size, 2, 3))}
    with Image.open(io.BytesIO(results_film.film(trace))) as film:
        assert len(list(ImageSequence.Iterator(film))) == 3
        film.seek(2)
        assert film.info["duration"] > 1000
