# SPDX-License-Identifier: MIT
"""The loops in C++ take arrays of the right shape and type, as they are, or refuse them."""

from typing import Any

import numpy as np
import pytest
from flotilla import kernels

from sil.plant import hull
from sil.plant.hull import Array, HullParameters

BOATS = 3


def arguments() -> dict[str, Any]:
    hulls = hull.stack([HullParameters(1.0, 2.0, 0.4, 3.0, 19.0, 0.9)] * BOATS)
    rows = np.zeros((BOATS, 3))
    return {
        "eta": rows.copy(),
        "nu": np.ones((BOATS, 3)),
        "tau": np.ones((3, BOATS, 2)),
        "w": rows.copy(),
        "current": np.zeros((BOATS, 2)),
        "parameters": hulls,
        "h_s": 0.01,
    }


@pytest.mark.parametrize("name", ["nu", "tau", "w", "current", "parameters"])
def test_an_array_of_another_length_is_refused_by_name(name: str) -> None:
    given = arguments()
    given[name] = given[name][..., :-1].copy()
    with pytest.raises(ValueError, match=f"{name}: "):
        kernels.advance_hulls(**given)


@pytest.mark.parametrize(
    ("name", "wrong"),
    [
        ("eta", np.zeros((BOATS, 3), np.float32)),  # a copy would be sailed instead
        ("eta", np.zeros((3, BOATS)).T),
        ("nu", np.zeros(3 * BOATS)),
        ("w", np.zeros((BOATS, 3), int)),
    ],
)
def test_an_array_that_would_have_to_be_copied_is_refused(name: str, wrong: Array) -> None:
    with pytest.raises(TypeError):
        kernels.advance_hulls(**arguments() | {name: wrong})


def test_an_array_that_is_not_writable_is_refused() -> None:
    given = arguments()
    given["eta"].flags.writeable = False
    with pytest.raises(TypeError):
        kernels.advance_hulls(**given)


def test_rows_of_a_larger_array_are_sailed_in_place() -> None:
    stages = np.zeros((3, 2 * BOATS, 2))
    stages[:, BOATS:] = 1.0
    apart, within = arguments(), arguments()
    within["tau"] = stages[:, BOATS:]
    kernels.advance_hulls(**apart)
    kernels.advance_hulls(**within)
    assert within["eta"].tobytes() == apart["eta"].tobytes() and apart["eta"].any()
