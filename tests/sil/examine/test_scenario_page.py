# SPDX-License-Identifier: MIT
"""The page of scenarios explains every key."""

from sil.examine import scenario_page
from sil.scenario.scenario import FOLDER
from tests.turns import some


def test_every_key_has_a_meaning() -> None:
    rows = [line for line in scenario_page.tables().splitlines() if line.startswith("| `")]
    assert len(rows) > 90
    assert [row for row in some(rows) if not row.rsplit("|", 2)[1].strip()] == []


def test_every_scenario_is_on_the_page_with_its_first_words() -> None:
    table = scenario_page.scenario_table()
    for path in some(FOLDER.glob("*.toml")):
        (row,) = [line for line in table.splitlines() if f"`{path.stem}`](" in line]
        assert len(row.rsplit("|", 2)[1].split()) > 3


def test_a_keys_meaning_is_its_comment_and_the_lines_below() -> None:
    text = "[link]          # radio\nloss = 0.1      # share\n                # of packets\n"
    assert scenario_page.meanings(text + "# [[fault]]  # bad\n# value = 1  # much\n") == {
        ("link", ""): "radio",
        ("link", "loss"): "share of packets",
        ("fault", ""): "bad",
        ("fault", "value"): "much",
    }
