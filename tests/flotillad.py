# SPDX-License-Identifier: MIT
"""The program under test, for tests that start it."""

from pathlib import Path

import pytest

FLOTILLAD = Path(__file__).parents[1] / "build" / "release" / "firmware" / "flotillad"


def needs_flotillad() -> None:
    """Skip the test, with what builds the program, where there is none."""
    if not FLOTILLAD.exists():
        pytest.skip(f"{FLOTILLAD} is not built: tools/build release flotillad")
