# SPDX-License-Identifier: MIT
"""The reference pages agree with the firmware."""

from pathlib import Path

import flotilla
import pytest

from sil.examine import hull_page, reference_pages, supervisor_page
from sil.scenario import presets
from tests.turns import some


@pytest.mark.parametrize("path", reference_pages.TABLES, ids=lambda path: path.name)
def test_the_tables_of_the_firmwares_pages_are_those_of_the_firmware(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert reference_pages.page(path, text) == text, "run tools/reference"


def test_a_page_that_lost_its_marks_is_an_error() -> None:
    with pytest.raises(ValueError, match="no place for the table of parameters"):
        reference_pages.page(reference_pages.PAGE, "")


def row_of(table: str, name: str) -> list[str]:
    (line,) = [line for line in table.splitlines() if f"`{name}`" in line]
    return [cell.strip() for cell in line.split("|")[2:-1]]


def test_the_loss_table_has_each_losss_effect_and_the_way_back() -> None:
    losses = supervisor_page.loss_table()
    assert row_of(losses, "escs_online") == ["FAULT; disarm first"] * 9
    # in HOLD, MANUAL, FORMATION, COAST, TEST, AUTO, GUIDED, LOITER, RTL
    assert row_of(losses, "leader_fresh") == ["", "", "COAST; by itself", *[""] * 6]
    held = "HOLD; asked for"
    assert row_of(losses, "own_fresh") == ["", "", held, held, "", held, held, held, held]
    back = "RTL; asked for"
    assert row_of(losses, "inside_fence") == ["", "", back, back, "", back, back, back, ""]
    assert row_of(losses, "coast_running")[3] == "HOLD; asked for"


def test_the_condition_table_has_each_conditions_limit_and_modes() -> None:
    conditions = supervisor_page.condition_table()
    assert row_of(conditions, "own_fresh")[-2:] == ["`FS_NAV_S`", "for every mode of the law"]
    assert row_of(conditions, "gcs_heard")[-2:] == [
        "`FS_GCS_S`",
        "to arm, for FORMATION, for AUTO, for GUIDED",
    ]
    assert row_of(conditions, "sticks_centred")[-2:] == ["", "for thrust in MANUAL"]
    assert row_of(conditions, "sticks_fresh")[-2:] == ["", "for MANUAL"]
    assert all(name in conditions for name in some(supervisor_page.NAMES))


def test_the_choice_table_has_each_choices_effect() -> None:
    choices = supervisor_page.choice_table()
    coast = "COAST, then `FS_COAST_ACT` decides"
    lost = "any `leader_…` condition lost"
    assert f"| `FS_LEADER_ACT` 1 (default) | {lost} | {coast} | {coast} |" in choices
    assert "| `FS_GCS_ACT` 2 | no `gcs_heard` | HOLD | MANUAL |" in choices
    assert "| `FS_FENCE_ACT` 2 (default) | no `inside_fence` | RTL | RTL |" in choices
    assert "| `FS_COAST_ACT` 1 | COAST is over | LOITER | LOITER |" in choices


def test_the_diagram_shows_each_state_and_no_way_out_of_fault_but_disarming() -> None:
    edges = supervisor_page.edges()
    assert {to for _, to in edges} | {"DISARMED"} == set(flotilla.STATES)
    assert not [to for state, to in edges if state == "FAULT"]
    assert edges["COAST", "FORMATION"] == ["all is well again"]
    assert edges["DISARMED", "HOLD"] == ["arm"]


@pytest.mark.parametrize("name", hull_page.files())
def test_parameter_files_are_those_of_their_hulls(name: str) -> None:
    text = (presets.FOLDER / name).read_text(encoding="utf-8")
    assert text == hull_page.files()[name], "run tools/reference"
