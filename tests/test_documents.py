# SPDX-License-Identifier: MIT
"""All links of the pages work, and all files that they name exist."""

import importlib.util
import re
from pathlib import Path

import pytest

from tests import measurements
from tests.turns import some

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *(ROOT / ".github").glob("*.md")]
PAGES += [page for room in ("firmware", "sil") for page in sorted((ROOT / room).rglob("*.md"))]
LINK = re.compile(r"\]\(([^)\s]+)\)|(?:src|href)=\"([^\"]+)\"")
MODULE = re.compile(r"python -m ((?:sil|tests)[\w.]*)")
FILE = re.compile(r"`((?:firmware|sil|tools|tests)/[\w./]+\w)`")


def prose(page: Path) -> str:
    """The page without its blocks of code."""
    return re.sub(r"^```.*?^```$", "", page.read_text(encoding="utf-8"), flags=re.DOTALL | re.M)


def anchors(page: Path) -> set[str]:
    """The anchors of its headings, by GitHub's rules."""
    heads = re.findall(r"^#+ (.+)$", prose(page), re.M)
    return {re.sub(r"[^\w\- ]", "", head).strip().lower().replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", some(PAGES), ids=lambda page: str(page.relative_to(ROOT)))
def test_links_and_files_that_a_page_names_are_there(page: Path) -> None:
    dead = []
    for link in ("".join(found) for found in LINK.findall(prose(page))):
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        if not re.match(r"\w+:", link):
            found = target.exists() and (not anchor or anchor in anchors(target))
            dead += [] if found else [link]
    dead += [name for name in FILE.findall(prose(page)) if not (ROOT / name).exists()]
    modules = MODULE.findall(page.read_text(encoding="utf-8"))
    dead += [name for name in modules if not importlib.util.find_spec(name)]
    assert dead == []


def test_every_page_is_in_the_menu_of_the_site() -> None:
    menu = (ROOT / "tools" / "mkdocs.yml").read_text(encoding="utf-8")
    assert [page for page in PAGES if f": {page.relative_to(ROOT)}\n" not in menu] == []


def test_the_functions_of_the_walk_are_in_the_files_that_it_names() -> None:
    walk = (ROOT / "firmware" / "docs" / "WALK.md").read_text(encoding="utf-8")
    steps = re.findall(r"^\| (\d+) \| `([\w:]+)` \| `([\w./]+)` \|", walk, re.M)
    assert [int(number) for number, _, _ in steps] == list(range(1, len(steps) + 1))
    assert len(steps) > 30
    for _, function, file in steps:
        source = (ROOT / file).read_text(encoding="utf-8")
        *of, name = function.split("::")
        defined = rf"\b{of[0]}(<S>)?::{name}\(" if of and file.endswith("cpp") else rf"\b{name}\("
        assert re.search(defined, source), f"{file} lacks {function}"
        assert all(re.search(rf"\b{room}\b", source) for room in of), f"{file} lacks {function}"


def test_the_figure_of_the_readme_is_the_measured_one() -> None:
    measured = measurements.row("four 2 m catamarans")[1]
    assert f"four 2 m catamarans stay within {measured} RMS" in prose(PAGES[0])


def test_every_page_can_be_reached_from_the_readme() -> None:
    seen, found = set(), [PAGES[0].resolve()]
    while found:
        page = found.pop()
        seen.add(page)
        links = (path.partition("#")[0] for path, _ in LINK.findall(prose(page)) if path)
        targets = {(page.parent / path).resolve() for path in links if path.endswith(".md")}
        found += targets - seen
    assert {page.resolve() for page in PAGES} <= seen
