# SPDX-License-Identifier: MIT
"""Guards against test loops that run zero times and so assert nothing."""

from collections.abc import Iterable
from typing import TypeVar

T = TypeVar("T")


def some(things: Iterable[T]) -> list[T]:
    """The same items; fails if there are none."""
    found = list(things)
    assert found, "nothing to look at"
    return found
