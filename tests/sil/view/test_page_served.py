# SPDX-License-Identifier: MIT
"""tools/view's own server and page in Chromium, with real boats' messages."""

import json
import random
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from sil.bench.page_cost import Said, said_by
from sil.cli.main import main as sil
from sil.live.free_port import free_port
from sil.scenario import scenario
from sil.wire.mavlink_mcast import LOOPBACK
from tests.sil.campaign.short import short
from tests.sil.view.browser import Browser
from tests.sil.view.feed import BEAT, attitude, local, origin, said
from tests.sil.view.live_page import CARD, LIVE

FAULT = "fault=[{kind='radio_silent', agent=0, at_s=4.0}]"
STATE = f"{CARD} return card && card.querySelector('.state').textContent === arguments[1]"


@contextmanager
def shown(browser: Browser, *arguments: str) -> Iterator["subprocess.Popen[str]"]:
    """Open the page of a view in its own process; closes it before the view ends."""
    view = subprocess.Popen(
        [sys.executable, "-m", "sil", "view", *arguments, "--bind", f"{LOOPBACK}:0"],
        stdout=subprocess.PIPE,
        text=True,
    )
    try:
        assert view.stdout is not None
        browser.open(view.stdout.readline().split()[-1])
        yield view
    finally:
        browser.open("about:blank")
        view.send_signal(signal.SIGINT)
        view.communicate(timeout=60.0)
    assert view.returncode == 0


@contextmanager
def saying(port: int, chunks: Said) -> Iterator[None]:
    """Send the chunks in real time, in a thread."""
    over = threading.Event()

    def say() -> None:
        began_s = time.monotonic()
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as end:
            for at_s, data in chunks:
                if over.wait(max(0.0, began_s + at_s - time.monotonic())):
                    return
                end.sendto(data, (LOOPBACK, port))

    thread = threading.Thread(target=say)
    thread.start()
    try:
        yield
    finally:
        over.set()
        thread.join()


@pytest.fixture(scope="module")
def lost() -> Said:
    """The traffic of `diamond` with a virtual leader that falls silent after 4 s."""
    return said_by(scenario.load("diamond", ["duration_s=14", "parameters.SR_STATE=10", FAULT]))


def silenced(chunks: Said, system: int, from_s: float) -> Said:
    """The same chunks without a system's messages from a time on."""
    return [(at_s, d) for at_s, d in chunks if at_s < from_s or d[5] != system]


def places(browser: Browser, names: Sequence[str]) -> Any:
    script = "return arguments[0].map((k) => flotilla.shown.vessels.find((v) => v.key === k).x_m)"
    return browser.run(script, names)


def test_real_boats_move_and_their_lost_leader_is_seen(browser: Browser, lost: Said) -> None:
    port = free_port()
    with shown(browser, f"udpin:{LOOPBACK}:{port}", "--length", "1.2"):
        browser.until(LIVE)
        assert "nothing" in browser.run("return document.body.innerText").lower()
        # once the leader's radio is silent, the view must not hear it either
        with saying(port, silenced(lost, 100, 4.0)):
            for number in (1, 2, 3, 4):
                browser.until(STATE, f"Boat {number}", "FORMATION")
            names = ["1", "2", "3", "4"]
            before = places(browser, names)
            browser.until(
                "return flotilla.shown.t_s > arguments[0]",
                browser.run("return flotilla.shown.t_s") + 1,
            )
            assert all(a != b for a, b in zip(before, places(browser, names), strict=True))
            browser.until(STATE, "Boat 1", "COAST")
            why = f"{CARD} return card.querySelector('.held').textContent === arguments[1]"
            browser.until(why, "Boat 1", "leader lost or origin unknown")
            browser.until(STATE, "Boat 1", "HOLD")


def test_garbage_and_a_fleet_that_comes_back_leave_the_page_up(
    browser: Browser, lost: Said
) -> None:
    rng, port = random.Random(8), free_port()
    noise = [(0.02 * k, rng.randbytes(300)) for k in range(50)]
    here = [origin(-337_000_000, 1_510_000_000), attitude(0.3, 99_000_000)]
    crowd = [
        (0.5 * turn, said(system, BEAT, *here, local(float(system), 0.0)))
        for turn in range(4)
        for system in range(1, 101)
    ]
    with shown(browser, f"udpin:{LOOPBACK}:{port}"):
        with saying(port, sorted([*noise, *crowd])):
            browser.until("return document.querySelectorAll('.card').length === 100")
            browser.until("return / damaged/.test(document.getElementById('heard').textContent)")
        # the four come back at the other end of the world, their clocks begin anew
        with saying(port, [(at_s + 6.0, data) for at_s, data in lost]):
            browser.until("return document.querySelectorAll('.card').length === 5")
            browser.until(STATE, "Boat 4", "FORMATION")
            assert abs(places(browser, ["4"])[0]) < 50.0


def test_a_run_is_played_back(browser: Browser, tmp_path: Path) -> None:
    assert sil(["run", str(short(tmp_path)), "--out", str(tmp_path / "run")]) == 0
    with shown(browser, str(tmp_path / "run")):
        browser.until("return document.querySelectorAll('.card').length === 5")
        browser.until(STATE, "Boat 1", "FORMATION")


def test_view_that_is_over_goes_on_as_a_replay_over_the_chart(
    browser: Browser, lost: Said, tmp_path: Path
) -> None:
    port, coast = free_port(), tmp_path / "coast.geojson"
    # a line from the west to the east through the frame's origin
    line = [[2.295 - 0.01, 48.7], [2.295 + 0.01, 48.7]]
    coast.write_text(json.dumps({"type": "LineString", "coordinates": line}))
    with shown(browser, f"udpin:{LOOPBACK}:{port}", "--chart", str(coast)) as view:
        with saying(port, lost):
            browser.until(STATE, "Boat 4", "FORMATION")
            drawn = """const { camera, canvas } = flotilla.plan;
              const [x, y] = camera.at(0, flotilla.shown.vessels[0].y_m + 1.5);
              const { data } = canvas.getContext('2d').getImageData(x - 2, y - 4, 4, 8);
              return [...Array(32).keys()].some((i) =>
                data[4 * i] === 0x8a && data[4 * i + 1] === 0x6d && data[4 * i + 2] === 0x3b)"""
            browser.until("return flotilla.chart.about !== null && flotilla.chart.path && true")
            browser.until(drawn)
        view.send_signal(signal.SIGUSR1)
        # it plays by itself; a slow machine may look only after its end
        begun = "flotilla.player && flotilla.shown && flotilla.source.t_s > flotilla.source.begin_s"
        browser.until(f"return {begun} && true")
        assert browser.run("return document.getElementById('speed').value") == "4"
        assert "the messages heard" in browser.run("return document.title")
        assert [v["id"] for v in browser.run("return flotilla.shown.vessels")] == [1, 2, 3, 4, 100]
        browser.until("return flotilla.shown.t_s === flotilla.source.end_s")
