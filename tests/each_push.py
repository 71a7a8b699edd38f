# SPDX-License-Identifier: MIT
"""Parameters of which each push tests a few, and --all every one."""

from collections.abc import Collection, Iterable

import pytest


def few(every: Iterable[object], each_push: Collection[object]) -> list[object]:
    """All values as parameters, nightly but for those of `each_push`; a tuple is a test's row."""
    values = list(every)
    assert each_push and all(one in values for one in each_push), "no push would test it"
    return [
        pytest.param(
            *(value if isinstance(value, tuple) else (value,)),
            marks=() if value in each_push else pytest.mark.nightly,
        )
        for value in values
    ]
