# SPDX-License-Identifier: MIT
"""The table of sil/docs/POLICIES.md: the rules that every boat must obey."""

import flotilla

from sil import ROOT

PAGE = ROOT / "sil" / "docs" / "POLICIES.md"


def table() -> str:
    """The rules, each as a row of a Markdown table."""
    lines = ["| group | rule |", "|---|---|"]
    lines += [f"| {group} | {name} |" for group, name in flotilla.policies()]
    return "\n".join(lines)
