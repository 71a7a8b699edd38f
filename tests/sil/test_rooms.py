# SPDX-License-Identifier: MIT
"""The folders of `sil`: each imports only earlier ones, none imports tests."""

import ast
from collections.abc import Iterator
from pathlib import Path

import sil

SIL = Path(sil.__file__).parent
ORDER = [
    "common",
    "plant",
    "wire",
    "scenario",
    "lockstep",
    "rivals",
    "live",
    "view",
    "fleet",
    "logs",
    "report",
    "identify",
    "certificate",
    "campaign",
    "results",
    "bench",
    "faults",
    "examine",
    "doctor",
    "cli",
    "examples",
]


def imported(path: Path) -> Iterator[str]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def rooms_used_by(path: Path) -> set[str]:
    return {name.split(".")[1] for name in imported(path) if name.startswith("sil.")} - {"ROOT"}


def test_every_module_is_in_a_room() -> None:
    top = {path.name for path in SIL.glob("*.py")}
    assert top == {"__init__.py", "__main__.py"}
    assert {path.parent.name for path in SIL.glob("*/*.py")} == set(ORDER)


def test_rooms_import_only_earlier_ones() -> None:
    for path in SIL.rglob("*/*.py"):
        room = path.relative_to(SIL).parts[0]
        later = rooms_used_by(path) - set(ORDER[: ORDER.index(room) + 1])
        assert not later, f"{path} imports {later}"


def test_sil_imports_no_tests() -> None:
    for path in SIL.rglob("*.py"):
        assert not any(name.split(".")[0] == "tests" for name in imported(path)), path


def test_modules_have_names_of_their_own() -> None:
    names = [path.stem for path in SIL.rglob("*.py") if not path.stem.startswith("__")]
    assert sorted(set(names)) == sorted(names)
