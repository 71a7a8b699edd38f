# SPDX-License-Identifier: MIT
"""A boat for each test, and its operator's programs."""

from collections.abc import Iterator
from contextlib import closing
from pathlib import Path

import pytest

from tests.clients.boat import Sea
from tests.clients.mavproxy_client import MavProxy
from tests.clients.mavsdk_client import MavsdkClient
from tests.flotillad import needs_flotillad
from tests.linux.conftest import bus

__all__ = ["bus"]


@pytest.fixture
def autopilot() -> float:
    """The boat's MAV_AUTOPILOT; see BOTH_IDENTITIES."""
    return 0.0


@pytest.fixture
def sea(bus: int, tmp_path: Path, autopilot: float) -> Iterator[Sea]:
    """A boat's sea; prints all output at the end, which pytest shows if the test fails."""
    needs_flotillad()
    with Sea(bus, tmp_path, autopilot) as sea:
        yield sea
        print(sea.words)


@pytest.fixture
def escs_silent(sea: Sea) -> None:
    """ESCs that are silent from the beginning."""
    sea.escs_on = False


@pytest.fixture
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty home directory: MAVSDK keeps what it has downloaded in $HOME/.cache."""
    home = tmp_path / "home"
    home.mkdir()
    monkeypatch.setenv("HOME", str(home))
    return home


@pytest.fixture
def mavsdk(sea: Sea, home: Path) -> Iterator[MavsdkClient]:
    with closing(MavsdkClient(sea)) as client:
        yield client


@pytest.fixture
def mavproxy(sea: Sea, home: Path) -> Iterator[MavProxy]:
    with closing(MavProxy(sea, home)) as client:
        yield client


@pytest.fixture
def ready(sea: Sea, mavproxy: MavProxy) -> MavProxy:
    """MAVProxy that has found the boat, and the boat fit to arm."""
    mavproxy.until_it_says("online system 2")
    sea.until(lambda: sea.armable)
    return mavproxy
