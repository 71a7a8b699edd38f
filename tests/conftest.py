# SPDX-License-Identifier: MIT
"""The option --all: tests marked `nightly` run only with it."""

import gc

import pytest

import sil  # noqa: F401 (before anything imports numpy: it sets the threads)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--all", action="store_true", help="run the tests marked nightly too")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    if config.getoption("--all"):
        return
    nightly = [item for item in items if item.get_closest_marker("nightly")]
    config.hook.pytest_deselected(items=nightly)
    items[:] = [item for item in items if item not in nightly]


def pytest_collection_finish() -> None:
    # thousands of tests and all their modules: the collector need not look at them again and again
    gc.freeze()
