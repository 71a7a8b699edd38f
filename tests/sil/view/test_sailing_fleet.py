# SPDX-License-Identifier: MIT
"""End to end: boats in real time, heard on a multicast group, seen in a browser."""

import json
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import common as mavlink

from sil.live.free_port import free_port
from sil.live.live_world import LiveWorld, build
from sil.scenario import scenario
from sil.view import page
from sil.view.history import numbers
from sil.view.tlog_history import history_of_tlog
from sil.wire.heartbeat import state_of
from sil.wire.mavlink_mcast import group_of, listener
from tests.live_buses import live_buses
from tests.punctual import sail_punctually, world_late_s
from tests.sil.view.browser import Browser
from tests.sil.view.live_page import LIVE, word
from tests.sil.view.test_live_fleet import process
from tests.sil.view.test_page_replay import seek, standing
from tests.turns import some

ROOT = Path(__file__).parents[3]
PICTURES = ROOT / "build" / "view"
PARAMETERS = {"SR_SLOW": 5.0, "FS_LEADER_S": 1.0, "FS_COAST_S": 10.0}
POSE = ("x_m", "y_m", "psi_rad")
BOATS = ("Boat 1", "Boat 2", "Boat 3", "Boat 4")


class Ear:
    """Receives boat 1's HEARTBEATs by pymavlink; `at_s`: time of each state after the start."""

    def __init__(self, address: str) -> None:
        self.at_s: dict[str, float] = {}
        self._socket = listener(group_of(address.removeprefix("mcast:")))
        self._socket.setblocking(True)
        self._socket.settimeout(0.2)
        self._mav = mavlink.MAVLink(None)
        self._mav.robust_parsing = True
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._hear)
        self._thread.start()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._socket.close()

    def heard_at_s(self, state: str, patience_s: float = 30.0) -> float:
        """The time of that state, waited for: what boat 1 does before what the page shows."""
        give_up_s = time.monotonic() + patience_s
        while state not in self.at_s:
            assert time.monotonic() < give_up_s, f"boat 1 never said {state}, only {self.at_s}"
            time.sleep(0.05)
        return self.at_s[state]

    def _hear(self) -> None:
        while not self._ended.is_set():
            try:
                data = self._socket.recv(4096)
            except TimeoutError:
                continue
            for message in self._mav.parse_buffer(bytearray(data)) or []:
                if message.get_type() == "HEARTBEAT" and message.get_srcSystem() == 1:
                    self._note(message)

    def _note(self, beat: mavlink.MAVLink_message) -> None:
        state = state_of(beat.custom_mode, beat.base_mode, beat.system_status)
        if state is not None and (self.at_s or state == "FORMATION"):
            self.at_s.setdefault(state, time.monotonic())


class Voyage:
    """`diamond` in real time in a thread, until `end`."""

    def __init__(self, bus: str, address: str, out: Path) -> None:
        sailed = scenario.load("diamond", ["duration_s=120"])
        self._world = LiveWorld(sailed, bus, PARAMETERS, address)
        self._out = out
        self._silent = self._ended = False
        self._mistake: BaseException | None = None
        self._thread = threading.Thread(target=self._sail)
        self._thread.start()

    def silence_leader(self) -> None:
        self._silent = True

    def end(self) -> None:
        self._ended = True
        self._thread.join()
        if self._mistake is not None:  # perhaps only late: see sail_punctually
            raise AssertionError("the voyage ended early") from self._mistake

    def _sail(self) -> None:
        class EndedError(Exception):
            pass

        def progress(_: float) -> None:
            if self._silent:
                self._world._leader.outbox = []
            if self._ended:
                raise EndedError

        try:
            with self._world as world:
                try:
                    world.run(build(print), self._out, progress)
                finally:  # a boat rightly stops if its data come late: see sail_punctually
                    late = {"late_s": 1e-6 * world.late_us}
                    (self._out / "summary.json").write_text(json.dumps(late), encoding="utf-8")
        except EndedError:
            pass
        except BaseException as error:  # raised where the result is awaited
            self._mistake = error


@contextmanager
def sailing(address: str, out: Path) -> Iterator[Voyage]:
    with live_buses() as bus:
        voyage = Voyage(bus, address, out)
        try:
            yield voyage
        finally:
            voyage.end()


def seen_at_s(browser: Browser, state: str) -> float:
    """The time by which the card of boat 1 shows that state: COAST must be seen while it lasts."""
    browser.until(f"{STATE_OF} === arguments[1]", "Boat 1", state)
    return time.monotonic()


STATE_OF = """return [...document.querySelectorAll('.card')].find((c) =>
  c.getAttribute('aria-label') === arguments[0])?.querySelector('.state').textContent"""


def shown(browser: Browser) -> dict[int, dict[str, Any]]:
    """The vessels of the page's present frame, by system id."""
    vessels = browser.run("return flotilla.shown.vessels")
    return {vessel["id"]: vessel for vessel in vessels}


def places(browser: Browser) -> dict[int, tuple[float, float]]:
    return {number: (v["x_m"], v["y_m"]) for number, v in shown(browser).items()}


def test_a_fleet_whose_leader_falls_silent_is_seen_as_it_happens(
    browser: Browser, tmp_path: Path
) -> None:
    build(print)
    PICTURES.mkdir(parents=True, exist_ok=True)
    coasting: dict[int, dict[str, Any]] = {}

    def sail(out: Path) -> None:
        address = f"mcast:239.255.145.64:{free_port()}"
        ear = Ear(address)
        try:
            with process("sil", "view", address, "--bind", "127.0.0.1:0") as view:
                assert view.stdout is not None
                browser.open(view.stdout.readline().split()[-1])
                browser.until(LIVE)
                try:
                    with sailing(address, out) as voyage:
                        coasting.update(watched(browser, ear, voyage))
                finally:
                    browser.open("about:blank")
        finally:
            ear.close()
        replayed(browser, out / "boat1" / "log", coasting, world_late_s(out))

    sail_punctually(sail, tmp_path)


def watched(browser: Browser, ear: Ear, voyage: Voyage) -> dict[int, dict[str, Any]]:
    """The vessels shown in COAST: the leader falls silent when all have been seen to move."""
    for name in BOATS:
        browser.until(f"{STATE_OF} === 'FORMATION'", name, patience_s=150.0)  # a live run starts
    before = places(browser)
    began_s = browser.run("return flotilla.shown.t_s")
    browser.until("return flotilla.shown.t_s > arguments[0]", began_s + 8.0)
    after = places(browser)
    assert all(after[system] != before[system] for system in (1, 2, 3, 4, 100))
    browser.picture(PICTURES / "formation.png")
    voyage.silence_leader()
    late_s, moments = {}, {}
    for state in ("COAST", "HOLD"):
        said_s = ear.heard_at_s(state)
        late_s[state] = seen_at_s(browser, state) - said_s
        # well after the change: a log is held against this by where the boat was
        browser.until(
            "return flotilla.shown.t_s > arguments[0]",
            browser.run("return flotilla.shown.t_s") + 1.0,
        )
        moments[state] = shown(browser)
        browser.picture(PICTURES / f"{state.lower()}.png")
    assert set(ear.at_s) == {"FORMATION", "COAST", "HOLD"}
    assert "leader" in word(browser, "Boat 1", ".held")
    assert word(browser, "Boat 2", ".state") == "FORMATION"
    print(f"shown after the boat had said it: {late_s}")
    return moments["COAST"]


def replayed(browser: Browser, tlog: Path, then: dict[int, dict[str, Any]], late_s: float) -> None:
    """Assert that boat 1's log replays the vessels `then`, of a world at most `late_s` late."""
    history = history_of_tlog(tlog)
    boat = next(vessel for vessel in history["vessels"] if vessel["id"] == 1)
    away_m = np.hypot(numbers(boat["x_m"]) - then[1]["x_m"], numbers(boat["y_m"]) - then[1]["y_m"])
    path = tlog.with_suffix(".html")
    path.write_text(page.page_with(history, "boat 1"), encoding="utf-8")
    standing(browser, path)

    def at(sample: int) -> dict[int, dict[str, Any]]:
        seek(browser, float(numbers(history["t_s"])[sample]))
        return shown(browser)

    same = int(np.nanargmin(away_m))
    # The page hears all from the world; boat 1 knows its own state at once, others late_s later.
    late = [at(same + k) for k in range(-1, 2 + ceil(late_s / 0.1))]
    now = at(same)
    for system, moments in ((1, [now]), (2, late), (100, late)):  # the systems that boat 1 hears
        pose, *poses = ([m[system][name] for name in POSE] for m in (then, *moments))
        assert any(other == pytest.approx(pose, abs=0.1) for other in poses), (system, pose, poses)
    for name in ("state", "held", "text", "leader"):
        assert now[1][name] == then[1][name]
    for esc, once in zip(some(now[1]["escs"]), then[1]["escs"], strict=True):
        assert esc["voltage_V"] == pytest.approx(once["voltage_V"], abs=0.1)
        assert esc["rpm"] == pytest.approx(once["rpm"], abs=200)  # told 5 times a second
        assert esc["errors"] == once["errors"]
    browser.picture(PICTURES / "replayed.png")
