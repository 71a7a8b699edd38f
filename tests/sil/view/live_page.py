# SPDX-License-Identifier: MIT
"""The live page of a made-up fleet, open in the browser."""

from tests.sil.view.browser import Browser
from tests.sil.view.feeder import Feeder, Frames

CARD = """const card = [...document.querySelectorAll('.card')].find((c) =>
  c.getAttribute('aria-label') === arguments[0]);"""
LIVE = "return document.getElementById('status').textContent === 'live'"


def shown(browser: Browser, feeder: Feeder, frames: Frames | None = None) -> None:
    """Opens the page and waits for the first frame."""
    if frames is not None:
        feeder.frames = frames
    browser.open(feeder.url)
    browser.until(LIVE)


def word(browser: Browser, name: str, place: str) -> str:
    text: str = browser.run(f"{CARD} return card?.querySelector('{place}').textContent", name)
    return text
