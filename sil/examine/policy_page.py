# SPDX-License-Identifier: MIT
"""The table of sil/POLICIES.md: the rules that every boat is watched by."""

import flotilla

from sil import ROOT

PAGE = ROOT / "sil" / "POLICIES.md"


def table() -> str:
    """The rules, each as a row of a Markdown table."""
    lines = ["| about | what holds in every tick |", "|---|---|"]
    lines += [f"| {group} | {name} |" for group, name in flotilla.policies()]
    return "\n".join(lines)
