# SPDX-License-Identifier: MIT
"""Against loops of tests that assert nothing because they run zero times."""

from collections.abc import Iterable
from typing import TypeVar

T = TypeVar("T")


def some(things: Iterable[T]) -> list[T]:
    """All of them; fails where there is none."""
    found = list(things)
    assert found, "nothing to look at"
    return found
