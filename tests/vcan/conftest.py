# SPDX-License-Identifier: MIT
"""Tests on the kernel's own CAN, with vcan0 … vcan3: tools/with-vcan pytest tests/vcan."""

import socket
from collections.abc import Callable, Generator, Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from tests.punctual import MOST_LATE
from tests.vcan.boat import Boat
from tests.vcan.bus import run

ECHO = Path("/sys/module/vcan/parameters/echo")
CAN_RAW_ERR_FILTER = 2  # linux/can/raw.h; Python's socket has it not everywhere

OpenRaw = Callable[..., socket.socket]
Shape = Callable[..., None]


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(
    item: pytest.Function, call: pytest.CallInfo[None]
) -> Generator[None, pytest.TestReport, pytest.TestReport]:
    """A test is not judged if it fails with a boat that the machine did not run in time."""
    report = yield
    boat = item.funcargs.get("boat")
    if not (call.when == "call" and report.failed and isinstance(boat, Boat)):
        return report
    late = boat.lateness()
    if late > MOST_LATE:
        seen = report.longreprtext.splitlines()[-1]
        why = f"not judged: this machine is too slow: late in {late:.0%} of the ticks; {seen}"
        report.outcome = "skipped"
        report.longrepr = (str(item.path), item.location[1] or 0, f"Skipped: {why}")
    return report


@pytest.fixture(autouse=True, scope="session")
def _vcan() -> None:
    if "vcan0" not in {name for _, name in socket.if_nameindex()}:
        pytest.skip("needs vcan: run tools/with-vcan pytest tests/vcan")


@pytest.fixture
def raw() -> Iterator[OpenRaw]:
    """Opens raw CAN sockets with a timeout; closes them after the test."""
    with ExitStack() as sockets:

        def raw(interface: str, error_mask: int = 0) -> socket.socket:
            """`error_mask`: the classes of error frames to receive."""
            can = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
            sockets.enter_context(can)
            can.setsockopt(socket.SOL_CAN_RAW, CAN_RAW_ERR_FILTER, error_mask)
            can.bind((interface,))
            can.settimeout(5.0)
            return can

        yield raw


@pytest.fixture
def shape() -> Iterator[Shape]:
    """Sets an interface's queueing discipline, or its plain one again: tc(8)."""
    if ECHO.read_text().strip() != "Y":
        pytest.skip(f"needs vcan loaded with echo=1, {ECHO} says no")
    shaped: set[str] = set()

    def shape(interface: str, *discipline: str, execute: Callable[..., None] = run) -> None:
        """`execute`: runs tc while the simulation goes on."""
        verb = "replace" if discipline else "delete"
        execute("tc", "qdisc", verb, "dev", interface, "root", *discipline)
        (shaped.add if discipline else shaped.discard)(interface)

    yield shape
    for interface in shaped.copy():
        shape(interface)
