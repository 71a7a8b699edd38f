# SPDX-License-Identifier: MIT
"""Asserts how every command reports a usage error."""

import pytest


def assert_told_in_one_line(said: str, capsys: pytest.CaptureFixture[str]) -> None:
    error = capsys.readouterr().err
    assert error.startswith("error: ") and error.count("\n") == 1
    assert said in error
