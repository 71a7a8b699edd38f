# SPDX-License-Identifier: MIT
"""The page of rules lists the firmware's rules."""

import flotilla

from sil.examine import policy_page


def test_the_page_has_every_rule_of_the_firmware_and_no_other() -> None:
    text = policy_page.PAGE.read_text(encoding="utf-8")
    mark = "<!-- policies: made by tools/reference -->\n"
    assert f"{mark}{policy_page.table()}\n<!-- end -->" in text, "run tools/reference"
    assert policy_page.table().count("\n") == 1 + len(flotilla.policies())
