# SPDX-License-Identifier: MIT
"""Debian's Chromium without a screen, driven by W3C WebDriver."""

import base64
import json
import shutil
import subprocess
import time
import urllib.request
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
MISSING = "no chromium or no chromedriver: apt-get install chromium chromium-driver"
_PATIENCE_S = 60.0
_INSIDE = ("", "127.0.0.1", "localhost", "[::1]")


class Browser:
    """A session. `run` is JavaScript with `return`; its promises are waited for."""

    def __init__(self, url: str) -> None:
        self._url = url
        self._noted: list[dict[str, Any]] = []
        self._said: list[dict[str, Any]] = []

    def call(self, method: str, path: str, body: dict[str, Any] | None = None) -> Any:
        data = None if body is None else json.dumps(body).encode()
        request = urllib.request.Request(self._url + path, data, method=method)
        with urllib.request.urlopen(request, timeout=_PATIENCE_S) as answer:
            return json.load(answer)["value"]

    def open(self, url: str) -> None:
        self.call("POST", "/url", {"url": url})

    def run(self, script: str, *arguments: object) -> Any:
        return self.call("POST", "/execute/sync", {"script": script, "args": list(arguments)})

    def until(self, script: str, *arguments: object, patience_s: float = _PATIENCE_S) -> Any:
        """What `script` returns as soon as that is true; looked at every 50 ms."""
        give_up_s = time.monotonic() + patience_s
        while not (found := self.run(script, *arguments)):
            assert time.monotonic() < give_up_s, f"never true: {script}\n{self.said()}"
            time.sleep(0.05)
        return found

    def devtools(self, command: str, **parameters: object) -> Any:
        return self.call("POST", "/goog/cdp/execute", {"cmd": command, "params": parameters})

    def size(self, width: int, height: int, *, dark: bool = False) -> None:
        """Size of the page in CSS pixels, which no window has to have; colours by preference."""
        shape = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
        self.devtools("Emulation.setDeviceMetricsOverride", **shape)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.devtools("Emulation.setEmulatedMedia", features=[scheme])

    def press(self, key: str) -> None:
        keys = [{"type": "keyDown", "value": key}, {"type": "keyUp", "value": key}]
        actions = [{"type": "key", "id": "keyboard", "actions": keys}]
        self.call("POST", "/actions", {"actions": actions})

    def picture(self, path: Path) -> None:
        path.write_bytes(base64.b64decode(self.call("GET", "/screenshot")))

    def said(self) -> list[dict[str, Any]]:
        """All that the console has said so far."""
        self._said += self.call("POST", "/se/log", {"type": "browser"})
        return self._said

    def errors(self) -> list[str]:
        return [entry["message"] for entry in self.said() if entry["level"] == "SEVERE"]

    def noted(self) -> list[dict[str, Any]]:
        """DevTools' network events so far."""
        for entry in self.call("POST", "/se/log", {"type": "performance"}):
            message = json.loads(entry["message"])["message"]
            if message["method"].startswith("Network."):
                self._noted.append(message)
        return self._noted

    def forget(self) -> None:
        """Nothing was said or asked for so far."""
        self.said()
        self.noted()
        self._said, self._noted = [], []

    def asked_for(self) -> list[str]:
        """Every address that was asked for, by request or WebSocket."""
        names = {"Network.requestWillBeSent", "Network.webSocketCreated"}
        found = [message["params"] for message in self.noted() if message["method"] in names]
        return [
            params["request"]["url"] if "request" in params else params["url"] for params in found
        ]

    def asked_outside(self) -> list[str]:
        """Those of them that leave the machine."""
        own = ("file", "data", "blob", "about", "chrome")
        return [
            url
            for url in self.asked_for()
            if urlsplit(url).scheme not in own and urlsplit(url).hostname not in _INSIDE
        ]


@contextmanager
def chromium(folder: Path, *, noting: bool = True) -> Iterator[Browser]:
    """A browser that keeps its files in `folder`; `noting`: what it asks the network for."""
    assert CHROMIUM and DRIVER, MISSING
    log = folder / "chromedriver.log"
    command = [DRIVER, "--port=0", f"--log-path={log}"]
    driver = subprocess.Popen(command, stdout=subprocess.PIPE, text=True, env=_environment(folder))
    try:
        port = _port(driver)
        root = f"http://127.0.0.1:{port}/session"
        body = json.dumps({"capabilities": {"alwaysMatch": _capabilities(folder, noting)}}).encode()
        with urllib.request.urlopen(urllib.request.Request(root, body), timeout=60) as answer:
            session = json.load(answer)["value"]["sessionId"]
        browser = Browser(f"{root}/{session}")
        try:
            yield browser
        finally:
            browser.call("DELETE", "")
    finally:
        driver.terminate()
        driver.wait(30)
        assert driver.stdout is not None
        driver.stdout.close()


def _environment(folder: Path) -> dict[str, str]:
    return {"PATH": "/usr/bin:/bin", "HOME": str(folder), "LANG": "C.UTF-8"}


def _port(driver: "subprocess.Popen[str]") -> int:
    """Where the driver says that it listens."""
    assert driver.stdout is not None
    for line in driver.stdout:
        if "successfully on port " in line:
            return int(line.split("on port ")[1].strip().rstrip("."))
    raise AssertionError("chromedriver has not started")


def _capabilities(folder: Path, noting: bool) -> dict[str, Any]:
    flags = [
        "--headless=new",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-dev-shm-usage",
        "--disable-background-networking",
        "--disable-component-update",
        "--no-first-run",
        f"--user-data-dir={folder / 'profile'}",
    ]
    return {
        "goog:chromeOptions": {"binary": CHROMIUM, "args": flags},
        "goog:loggingPrefs": {"browser": "ALL", "performance": "ALL" if noting else "OFF"},
        "timeouts": {"script": 55_000},  # of 60 s for the request; 30 s are too few beside a build
    }


def shown_within(begin_s: float, condition: Callable[[], bool]) -> float:
    """Seconds from `begin_s` until `condition` was first true."""
    while not condition():
        assert time.monotonic() - begin_s < _PATIENCE_S
        time.sleep(0.01)
    return time.monotonic() - begin_s
