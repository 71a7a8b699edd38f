# SPDX-License-Identifier: MIT
"""The what-if panel: the supervisor in the browser against the firmware's."""

import random
from collections.abc import Iterator
from itertools import product
from pathlib import Path

import flotilla
import pytest

from sil.view import history, page
from tests.sil.view.browser import Browser

NAMES = [c["name"] for c in flotilla.supervisor_conditions()]
COMPLAINTS = {c["name"]: c["complaint"] for c in flotilla.supervisor_conditions()}
REQUESTS = sorted({row["request"] for row in flotilla.supervisor_table()})
CHOICES = [
    f"{choice['name']} {value}"
    for choice in flotilla.supervisor_choices()
    for value in range(len(choice["reactions"]))
]
SEED, RANDOM_SETS = 20261121, 25


@pytest.fixture
def panel(browser: Browser, tmp_path: Path) -> Browser:
    """The panel, open, its boat in FORMATION with all conditions met."""
    nothing = {"title": "nothing", "t_s": history.column([]), "vessels": []}
    path = tmp_path / "page.html"
    path.write_text(page.page_with(nothing, "nothing"), encoding="utf-8")
    browser.open(f"{path.as_uri()}#what-if")
    return browser


def sets_of_conditions() -> Iterator[list[str]]:
    yield []
    yield [*NAMES, *CHOICES]
    for name in [*NAMES, *CHOICES]:
        yield [name]
        yield [n for n in (*NAMES, *CHOICES) if n != name]
    rng = random.Random(SEED)
    for share in (0.5, 0.9):
        for _ in range(RANDOM_SETS):
            yield [name for name in (*NAMES, *CHOICES) if rng.random() < share]


def asked() -> list[tuple[str, str, list[str]]]:
    """All states and requests, each with several sets of conditions."""
    return [
        (state, request, met)
        for met, state, request in product(sets_of_conditions(), flotilla.STATES, REQUESTS)
    ]


def test_page_answers_as_the_firmware_to_every_state_and_request(panel: Browser) -> None:
    questions = asked()
    script = """return arguments[0].map((question) => {
      const { state, granted, missing, drives } = flotilla.supervise(...question);
      return [state, granted, missing.sort(), drives];
    })"""
    answers = panel.run(script, questions)
    wrong = []
    for question, answer in zip(questions, answers, strict=True):
        verdict = flotilla.supervise(*question)
        wanted = [verdict["state"], verdict["granted"], sorted(verdict["missing"])]
        if answer != [*wanted, verdict["drives"]]:
            wrong.append((question, answer, verdict))
    assert wrong == []
    assert len(questions) > 20_000


def state_of(panel: Browser) -> tuple[str, str]:
    """The state that the panel shows, and the reason."""
    words = """return ['#verdict .state', '#because'].map((place) =>
      document.querySelector(place).textContent)"""
    state, why = panel.run(words)
    return state, why


def click(panel: Browser, selector: str, text: str = "") -> None:
    script = """const all = [...document.querySelectorAll(arguments[0])];
      all.find((x) => !arguments[1] || x.textContent === arguments[1]).click()"""
    panel.run(script, selector, text)


def test_lost_leader_makes_the_boat_coast_then_hold_and_the_page_says_why(panel: Browser) -> None:
    assert state_of(panel)[0] == "FORMATION"
    click(panel, "#met-leader_fresh")
    state, why = state_of(panel)
    assert state == "COAST" and COMPLAINTS["leader_fresh"] in why
    click(panel, "#met-coast_running")
    state, why = state_of(panel)
    assert state == "HOLD" and COMPLAINTS["coast_running"] in why
    click(panel, "#requests button", "FORMATION")
    state, why = state_of(panel)
    assert state == "HOLD" and "refused" in why and COMPLAINTS["leader_fresh"] in why


def test_leader_that_comes_back_brings_the_boat_from_coast_to_formation(panel: Browser) -> None:
    click(panel, "#met-leader_fresh")
    click(panel, "#met-leader_fresh")
    assert state_of(panel) == ("FORMATION", "COAST → FORMATION by itself: all is well again")


@pytest.mark.parametrize("name", NAMES)
def test_each_lost_condition_leads_where_the_firmware_goes(panel: Browser, name: str) -> None:
    click(panel, f"#met-{name}")
    met = [n for n in NAMES if n != name] + ["FS_LEADER_ACT 1", "FS_GCS_ACT 0"]
    state = "FORMATION"
    for _ in flotilla.STATES:
        state = flotilla.supervise(state, "nothing", met)["state"]
    assert state_of(panel)[0] == state
    drives = flotilla.supervise(state, "nothing", met)["drives"]
    said = panel.run("return document.getElementById('verdict').textContent")
    assert ("propellers may turn" in said) == drives


def test_fs_leader_act_decides_the_reaction_to_a_lost_leader(panel: Browser) -> None:
    script = """const select = document.getElementById('FS_LEADER_ACT');
      select.value = arguments[0]; select.dispatchEvent(new Event('change'))"""
    panel.run(script, "0")
    click(panel, "#met-leader_fresh")
    assert state_of(panel)[0] == "HOLD"


def test_row_that_decided_is_marked_in_the_whole_table(panel: Browser) -> None:
    assert panel.run("return document.querySelectorAll('#rows tbody tr').length") == len(
        flotilla.supervisor_table()
    )
    click(panel, "#met-bus_up")
    assert state_of(panel)[0] == "FAULT"
    marked = panel.run("return [...document.querySelectorAll('.decided')].map((r) => r.rowIndex)")
    row = flotilla.supervisor_table()[marked[0] - 1]
    assert len(marked) == 1 and row["to"] == "FAULT" and "bus_up" in row["lacks"]


def test_panel_says_that_nothing_in_it_reaches_a_boat(panel: Browser) -> None:
    script = """const told = document.getElementById('apart'), box = told.getBoundingClientRect();
      return [told.textContent, box.top >= 0 && box.bottom <= innerHeight, box.width]"""
    text, seen, width = panel.run(script)
    assert text == "Nothing here reaches a boat" and seen and width > 600


def test_panel_fits_a_phone(panel: Browser) -> None:
    panel.size(360, 740)
    assert panel.run("return document.documentElement.scrollWidth") <= 360
