# SPDX-License-Identifier: MIT
"""The table of sil/docs/POLICIES.md: the rules that every boat is watched by."""

from pathlib import Path

import flotilla

PAGE = Path(__file__).with_name("docs") / "POLICIES.md"


def table() -> str:
    """The rules, each as a row of a Markdown table."""
    lines = ["| about | what holds in every tick |", "|---|---|"]
    lines += [f"| {group} | {name} |" for group, name in flotilla.policies()]
    return "\n".join(lines)
