# SPDX-License-Identifier: MIT
"""Debian's headless Chromium, driven by Selenium."""

import json
import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from selenium import webdriver
from selenium.webdriver.chrome.options import Options
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.remote.command import Command

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
MISSING = "no chromium or no chromedriver: apt-get install chromium chromium-driver"
_PATIENCE_S = 60.0
_INSIDE = ("", "127.0.0.1", "localhost", "[::1]")
_FLAGS = (
    "--headless=new",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-dev-shm-usage",
    "--disable-background-networking",
    "--disable-component-update",
    "--no-first-run",
)


class Browser:
    """A session. `run` is JavaScript with `return`; its promises are waited for."""

    def __init__(self, driver: webdriver.Chrome) -> None:
        self._driver = driver
        self._noted: list[dict[str, Any]] = []
        self._said: list[dict[str, Any]] = []
        self.open, self.run = driver.get, driver.execute_script

    def until(self, script: str, *arguments: object, patience_s: float = _PATIENCE_S) -> Any:
        """Evaluate `script` every 50 ms until it returns something true."""
        give_up_s = time.monotonic() + patience_s
        while not (found := self.run(script, *arguments)):
            assert time.monotonic() < give_up_s, f"never true: {script}\n{self.said()}"
            time.sleep(0.05)
        return found

    def devtools(self, command: str, **parameters: object) -> Any:
        return self._driver.execute_cdp_cmd(command, parameters)

    def size(self, width: int, height: int, *, dark: bool = False) -> None:
        """Set the page's size in CSS pixels, independent of the window, and the colour scheme."""
        shape = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": width < 500}
        self.devtools("Emulation.setDeviceMetricsOverride", **shape)
        scheme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.devtools("Emulation.setEmulatedMedia", features=[scheme])

    def still(self) -> None:
        """Prefer reduced motion until the next `size`."""
        motion = {"name": "prefers-reduced-motion", "value": "reduce"}
        self.devtools("Emulation.setEmulatedMedia", features=[motion])

    def act(self, *devices: dict[str, Any]) -> None:
        """Perform WebDriver actions of touch, mouse, wheel or keyboard."""
        self._driver.execute(Command.W3C_ACTIONS, {"actions": list(devices)})

    def press(self, key: str) -> None:
        keys = [{"type": "keyDown", "value": key}, {"type": "keyUp", "value": key}]
        self.act({"type": "key", "id": "keyboard", "actions": keys})

    def click(self, right: float, down: float) -> None:
        """Click the mouse at a position of the page."""
        move = {"type": "pointerMove", "x": round(right), "y": round(down)}
        press = [{"type": "pointerDown", "button": 0}, {"type": "pointerUp", "button": 0}]
        self.act({"type": "pointer", "id": "mouse", "actions": [move, *press]})

    def picture(self, path: Path) -> None:
        path.write_bytes(self._driver.get_screenshot_as_png())

    def said(self) -> list[dict[str, Any]]:
        """All console messages so far."""
        self._said += self._driver.get_log("browser")
        return self._said

    def errors(self) -> list[str]:
        return [entry["message"] for entry in self.said() if entry["level"] == "SEVERE"]

    def noted(self) -> list[dict[str, Any]]:
        """All network events of DevTools so far."""
        for entry in self._driver.get_log("performance"):
            message = json.loads(entry["message"])["message"]
            if message["method"].startswith("Network."):
                self._noted.append(message)
        return self._noted

    def forget(self) -> None:
        """Discard the console messages and network events so far."""
        self.said()
        self.noted()
        self._said, self._noted = [], []

    def asked_for(self) -> list[str]:
        """The addresses of all requests and WebSockets."""
        names = {"Network.requestWillBeSent", "Network.webSocketCreated"}
        found = [message["params"] for message in self.noted() if message["method"] in names]
        return [
            params["request"]["url"] if "request" in params else params["url"] for params in found
        ]

    def asked_outside(self) -> list[str]:
        """Those of them that are not on this machine."""
        own = ("file", "data", "blob", "about", "chrome")
        return [
            url
            for url in self.asked_for()
            if urlsplit(url).scheme not in own and urlsplit(url).hostname not in _INSIDE
        ]


@contextmanager
def chromium(folder: Path, *, noting: bool = True) -> Iterator[Browser]:
    """A browser with its files in `folder`; `noting`: record its network requests."""
    assert CHROMIUM and DRIVER, MISSING
    options = Options()
    options.binary_location = CHROMIUM
    for flag in (*_FLAGS, f"--user-data-dir={folder / 'profile'}"):
        options.add_argument(flag)
    logs = {"browser": "ALL", "performance": "ALL" if noting else "OFF"}
    options.set_capability("goog:loggingPrefs", logs)
    options.timeouts = {"script": 55_000}  # 30 s are too few beside a build
    home = {"PATH": "/usr/bin:/bin", "HOME": str(folder), "LANG": "C.UTF-8"}
    service = Service(DRIVER, log_output=str(folder / "chromedriver.log"), env=home)
    driver = webdriver.Chrome(options, service)
    try:
        yield Browser(driver)
    finally:
        driver.quit()
