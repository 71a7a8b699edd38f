# SPDX-License-Identifier: MIT
"""Tests marked `nightly` run only with --all; the longest files run first."""

import gc
import signal

import pytest

import sil  # noqa: F401 (before anything imports numpy: it sets the threads)

# Shells have background jobs ignore it, and the programs under test would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)

# A file runs in one worker: the longest ones, and those in real time, must start first.
FIRST = (
    "tests/loop/test_live.py",
    "tests/loop/test_published.py",
    "tests/loop/test_identified.py",
    "tests/sil/cli/test_certify.py",
    "tests/loop/test_published_fleets.py",
    "tests/sil/view/test_sailing_fleet.py",
    "tests/clients/test_mavproxy.py",
    "tests/clients/test_logs.py",
    "tests/clients/test_mavsdk.py",
    "tests/clients/test_missions.py",
    "tests/linux/mavlink/test_mavlink_endpoint.py",
    "tests/clients/test_live_gcs.py",
    "tests/linux/test_my_simulator.py",
    "tests/sil/identify/test_identification.py",
    "tests/sil/view/test_live_fleet.py",
    "tests/sil/view/test_page_live.py",
    "tests/sil/certificate/test_chain.py",
    "tests/loop/test_shapes.py",
    "tests/loop/test_voyage.py",
    "tests/loop/test_failsafes.py",
    "tests/loop/test_diamond.py",
    "tests/loop/test_succession.py",
    "tests/loop/test_encounters.py",
    "tests/loop/test_compare.py",
    "tests/linux/test_loop.py",
    "tests/sil/campaign/test_runner.py",
    "tests/sil/view/test_page_served.py",
    "tests/linux/files/test_parameter_file.py",
    "tests/sil/cli/test_identify.py",
    "tests/sil/rivals/test_rivals.py",
    "tests/loop/test_random_trees.py",
    "tests/sil/identify/test_real_logs.py",
    "tests/loop/test_leading.py",
    "tests/tools/test_with_vcan.py",
)


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--all", action="store_true", help="run the tests marked nightly too")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    place = {file: k for k, file in enumerate(FIRST)}
    items.sort(key=lambda item: place.get(item.nodeid.partition("::")[0], len(FIRST)))
    if config.getoption("--all"):
        return
    nightly = [item for item in items if item.get_closest_marker("nightly")]
    config.hook.pytest_deselected(items=nightly)
    items[:] = [item for item in items if item not in nightly]


def pytest_collection_finish() -> None:
    # keep the collector from scanning thousands of tests and their modules again and again
    gc.freeze()
