# SPDX-License-Identifier: MIT
"""Every imported package is declared, and every declared one is pinned."""

import ast
import re
import sys
import tomllib
from collections.abc import Mapping
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

ROOT = Path(__file__).parents[2]
OUR_OWN = {"firmware", "flotilla", "flotilla-usv", "sil", "tests"}


def plain(requirement: str) -> str:
    """A requirement's name, normalised as in package indices."""
    return re.sub(r"[-_.]+", "-", re.split(r"[=<> \[]", requirement, maxsplit=1)[0]).lower()


@cache
def distributions() -> Mapping[str, list[str]]:
    """The installed distributions of each module."""
    return packages_distributions()


def imported(*folders: str) -> set[str]:
    """The distributions imported in the folders."""
    modules: set[str] = set()
    for file in (file for folder in folders for file in (ROOT / folder).rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                modules |= {alias.name.split(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                modules.add(node.module.split(".")[0])
    return {
        plain(name)
        for module in modules - OUR_OWN - sys.stdlib_module_names
        for name in distributions().get(module, [module])
    }


def declared() -> set[str]:
    lines = (ROOT / "tools" / "requirements.in").read_text(encoding="utf-8").splitlines()
    return {plain(line) for line in lines if not line.startswith("#")}


def test_imports_of_the_simulation_are_declared() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    extras = [name for extra in project["optional-dependencies"].values() for name in extra]
    dependencies = {plain(name) for name in [*project["dependencies"], *extras]} - OUR_OWN
    assert imported("sil", "tools") == dependencies
    assert dependencies < declared()


def test_imports_of_the_tests_are_declared() -> None:
    used = imported("tests")
    assert {"pytest", "numpy", "pymavlink"} < used
    assert used <= declared()


def test_declared_packages_are_pinned_with_a_hash() -> None:
    text = (ROOT / "tools" / "requirements.txt").read_text(encoding="utf-8")
    pinned = re.findall(r"^([\w.-]+)==\S+ \\\n +--hash=sha256:[0-9a-f]{64}\b", text, re.MULTILINE)
    assert declared() <= {plain(name) for name in pinned}
