# SPDX-License-Identifier: MIT
"""Regenerates the reference pages' tables from the firmware's lists and the scenario's models."""

import sys
from pathlib import Path

import flotilla

from sil import ROOT
from sil.examine import (
    fault_page,
    hull_page,
    message_page,
    module_page,
    policy_page,
    scenario_page,
    supervisor_page,
)
from sil.scenario import presets

PAGE = ROOT / "firmware" / "docs" / "PARAMETERS.md"


def parameter_table() -> str:
    """Every parameter as a Markdown table."""
    lines = ["| name | unit | default | range | change | meaning |", "|---|---|---|---|---|---|"]
    for p in flotilla.parameter_list():
        span = f"{p['least']:.6g} … {p['greatest']:.6g}" + (", whole" if p["integer"] else "")
        default, unit = f"{p['default']:.6g}", p["unit"] or "–"
        cells = [f"`{p['name']}`", unit, default, span, p["change"], p["sentence"]]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


TABLES = {
    PAGE: {"parameters": parameter_table},
    supervisor_page.PAGE: {
        "choices": supervisor_page.choice_table,
        "conditions": supervisor_page.condition_table,
        "losses": supervisor_page.loss_table,
        "diagram": supervisor_page.diagram,
        "transitions": supervisor_page.transition_table,
    },
    message_page.PAGE: {"messages": message_page.table},
    fault_page.PAGE: {"faults": fault_page.table},
    policy_page.PAGE: {"policies": policy_page.table},
    scenario_page.PAGE: {"scenarios": scenario_page.scenario_table, "keys": scenario_page.tables},
    hull_page.PAGE: {
        "firmware": hull_page.firmware_table,
        "hulls": hull_page.source_tables,
    },
    module_page.PAGE: {
        "snapshot": module_page.snapshot_table,
        "counters": module_page.counter_table,
        "stub": module_page.stub,
    },
}


def page(path: Path, text: str) -> str:
    """Replace each table of the page between its `<!-- name -->` and `<!-- end -->` lines."""
    for name, table in TABLES[path].items():
        begin, end = f"<!-- {name}: made by tools/reference -->\n", "<!-- end -->"
        before, found, rest = text.partition(begin)
        _, ended, behind = rest.partition(end)
        if not (found and ended) or begin in behind:
            raise ValueError(f"{path}: no place for the table of {name}")
        text = f"{before}{begin}{table()}\n{end}{behind}"
    return text


def main() -> int:
    """Regenerate the pages, and the parameter files of the hulls."""
    for path in TABLES:
        path.write_text(page(path, path.read_text(encoding="utf-8")), encoding="utf-8")
    for name, text in hull_page.files().items():
        (presets.FOLDER / name).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
