# SPDX-License-Identifier: MIT
"""The tables of firmware/README.md, from the firmware's own lists."""

import re
import sys
from pathlib import Path

import flotilla

PAGE = Path(__file__).parent.parent / "firmware" / "README.md"


def parameter_table() -> str:
    """Every parameter as a Markdown table."""
    lines = ["| name | unit | default | range | change | meaning |", "|---|---|---|---|---|---|"]
    for p in flotilla.parameter_list():
        span = f"{p['least']:.6g} … {p['greatest']:.6g}" + (", whole" if p["integer"] else "")
        default, unit = f"{p['default']:.6g}", p["unit"] or "–"
        cells = [f"`{p['name']}`", unit, default, span, p["change"], p["sentence"]]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def transition_table() -> str:
    """The supervisor's table, row by row, as a Markdown table."""
    lines = ["| in state | asked | all of | or lost one of | goes to |", "|---|---|---|---|---|"]
    for row in flotilla.supervisor_table():
        cells = [", ".join(row["from"]), row["request"], ", ".join(row["needs"])]
        cells += [", ".join(row["lacks"]), row["to"]]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


TABLES = {"parameters": parameter_table, "transitions": transition_table}


def page(text: str) -> str:
    """The page with each table between its `<!-- name -->` and `<!-- end -->` lines renewed."""
    for name, table in TABLES.items():
        begin = f"<!-- {name}: made by tools/reference -->\n"
        pattern = re.escape(begin) + r".*?<!-- end -->"
        text, found = re.subn(pattern, f"{begin}{table()}\n<!-- end -->", text, flags=re.DOTALL)
        if found != 1:
            raise ValueError(f"{PAGE}: no place for the table of {name}")
    return text


def main() -> int:
    """Renews the page."""
    PAGE.write_text(page(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
