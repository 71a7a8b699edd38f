# SPDX-License-Identifier: MIT
"""A sea of its own for each test."""

import pytest

from tests.target.harness import Sea


@pytest.fixture
def sea() -> Sea:
    """A boat, its navigation unit, its leader and its two ESCs, all well."""
    return Sea()


@pytest.fixture
def sailing() -> Sea:
    """The same boat, armed and in FORMATION."""
    sea = Sea()
    sea.enter_formation()
    return sea
