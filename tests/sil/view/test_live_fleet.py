# SPDX-License-Identifier: MIT
"""The real command lines: boats that sail in real time, seen by a view of their MAVLink group."""

import asyncio
import json
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from math import hypot
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tornado.websocket import websocket_connect

from sil.cli.main import main
from sil.live.free_port import free_port
from sil.live.live_world import build
from tests.live_buses import live_buses
from tests.punctual import sail_punctually, world_late_s

_PATIENCE_S = 120.0
DURATION_S = 12


@contextmanager
def process(*arguments: str) -> Iterator[subprocess.Popen[str]]:
    running = subprocess.Popen(
        [sys.executable, "-m", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    try:
        yield running
    finally:
        if running.poll() is None:
            running.send_signal(signal.SIGINT)
        running.communicate(timeout=_PATIENCE_S)


async def frames_until(url: str, ended: Any) -> list[dict[str, Any]]:
    """All frames until a process has ended, and some more."""
    page = await websocket_connect(f"ws{url.removeprefix('http')}live")
    frames, more = [], 20
    try:
        async with asyncio.timeout(_PATIENCE_S):
            while more > 0 and (message := await page.read_message()) is not None:
                frames.append(json.loads(message))
                more -= ended() is not None
    finally:
        page.close()
        while await page.read_message() is not None:
            pass
    return frames


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> tuple[list[dict[str, Any]], Path]:
    """All frames of a view of a live run of `diamond`, and the run's folder."""
    build(print)
    frames: list[dict[str, Any]] = []

    def sail(out: Path) -> None:
        group = f"mcast:239.255.145.63:{free_port()}"
        with live_buses() as bus, process("sil", "view", group, "--bind", "127.0.0.1:0") as view:
            live = ["sil", "live", "diamond", "--bus", bus, "--duration", str(DURATION_S)]
            assert view.stdout is not None
            url = view.stdout.readline().split()[-1]
            with process(*live, "--mavlink", group, "--out", str(out)) as sailing:
                frames[:] = asyncio.run(frames_until(url, sailing.poll))
                told, _ = sailing.communicate(timeout=_PATIENCE_S)
                assert sailing.returncode == 0, told
        assert view.returncode == 0

    out = sail_punctually(sail, tmp_path_factory.mktemp("seen"))
    return frames, out


def test_all_boats_and_their_leader_are_seen_in_formation(
    seen: tuple[list[dict[str, Any]], Path],
) -> None:
    frames, _ = seen
    states = [{v["id"]: v["state"] for v in frame["vessels"]} for frame in frames]
    assert {1: "FORMATION", 2: "FORMATION", 3: "FORMATION", 4: "FORMATION", 100: None} in states
    assert "DISARMED" in {state for frame in states for state in frame.values()}
    assert frames[-1]["heard"]["damaged"] == 0


def test_boats_are_seen_where_the_run_says_that_they_were(
    seen: tuple[list[dict[str, Any]], Path],
) -> None:
    frames, out = seen
    with np.load(out / "trace.npz") as trace:
        eta, fastest_mps = trace["eta"], np.hypot(*trace["nu"][..., :2].T).max()
    # a boat extrapolates its motion while the simulation is late
    most_m = 0.05 + fastest_mps * world_late_s(out)
    paths = {agent: eta[:, agent, :2] for agent in range(1, 5)}
    moved = 0
    for frame in frames:
        for vessel in frame["vessels"]:
            if vessel["id"] in paths and vessel["x_m"] is not None:
                away = paths[vessel["id"]] - (vessel["x_m"], vessel["y_m"])
                assert np.hypot(*away.T).min() < most_m, vessel
                moved += hypot(*(paths[vessel["id"]][0] - (vessel["x_m"], vessel["y_m"]))) > 1.0
    assert moved > 40


def test_silent_boats_stay_on_the_page_with_their_age(
    seen: tuple[list[dict[str, Any]], Path],
) -> None:
    last = seen[0][-1]
    assert [v["id"] for v in last["vessels"]] == [1, 2, 3, 4, 100]
    assert all(v["link_age_s"] > 0.5 for v in last["vessels"])


@pytest.mark.parametrize("address", ["nowhere", "mcast:127.0.0.1:14550", "udpout:1"])
def test_an_invalid_address_for_mavlink_is_reported(
    address: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    live = ["live", "diamond", "--bus", "mcast:5", "--out", str(tmp_path)]
    assert main([*live, "--mavlink", address]) == 2
    assert f'error: "{address}"' in capsys.readouterr().err
