# SPDX-License-Identifier: MIT
"""The reference page says what the firmware says."""

import pytest

from sil import reference


def test_the_tables_of_the_firmwares_page_are_those_of_the_firmware() -> None:
    text = reference.PAGE.read_text(encoding="utf-8")
    assert reference.page(text) == text, "run tools/reference"


def test_a_page_that_lost_its_marks_is_an_error() -> None:
    with pytest.raises(ValueError, match="no place for the table of parameters"):
        reference.page("")
