# SPDX-License-Identifier: MIT
"""Interaction with the live page: pause, follow, drag, zoom."""

import pytest

from tests.sil.view.browser import Browser
from tests.sil.view.feeder import Feeder
from tests.sil.view.live_page import CARD, shown


def test_pause_holds_the_picture_and_going_on_shows_the_present(
    browser: Browser, four: Feeder
) -> None:
    shown(browser, four)
    browser.run("document.getElementById('pause').click()")
    paused = "return document.getElementById('status').textContent.startsWith('paused for')"
    browser.until(paused)
    held = browser.run("return flotilla.shown.t_s")
    browser.until("return flotilla.source.frame.t_s > arguments[0] + 0.5", held)
    assert browser.run("return flotilla.shown.t_s") == held
    browser.press(" ")
    browser.until("return flotilla.shown.t_s > arguments[0]", held)


def test_boat_that_is_followed_stays_in_the_middle(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    browser.run(f"{CARD} card.querySelector('button').click()", "Boat 3")
    middle = """const { width, height } = flotilla.plan.camera;
      const v = flotilla.shown.vessels.find((v) => v.id === 3);
      const [right, down] = flotilla.plan.camera.at(v.x_m, v.y_m);
      return Math.hypot(right - width / 2, down - height / 2) < 1e-6"""
    browser.until("return flotilla.plan.camera.mode === '3'")
    browser.until(middle)
    scale = browser.run("return flotilla.plan.camera.scale")
    browser.press("+")
    browser.until("return flotilla.plan.camera.scale > arguments[0]", scale)
    browser.until(middle)
    browser.press("f")
    browser.until("return flotilla.plan.camera.mode === 'fleet'")


def test_drag_moves_the_plan_and_the_wheel_zooms_where_it_points(
    browser: Browser, four: Feeder
) -> None:
    shown(browser, four)
    # the camera may follow the fleet until the very moment of the touch
    browser.run("""const { camera, canvas } = flotilla.plan;
      const note = () => { window.touched = [camera.north, camera.east]; };
      canvas.addEventListener('pointerdown', note, { capture: true, once: true });""")
    drag = [
        {"type": "pointerMove", "x": 300, "y": 300},
        {"type": "pointerDown", "button": 0},
        {"type": "pointerMove", "x": 380, "y": 340},
        {"type": "pointerUp", "button": 0},
    ]
    browser.act({"type": "pointer", "id": "mouse", "actions": drag})
    browser.until("return flotilla.plan.camera.mode === 'free'")
    script = """const { north, east, scale } = flotilla.plan.camera;
      return [(north - window.touched[0]) * scale, (east - window.touched[1]) * scale]"""
    assert browser.run(script) == pytest.approx([40.0, -80.0], abs=1.0)
    under = """const c = flotilla.plan.camera;
      const north = c.north - (200 - c.height / 2) / c.scale;
      return [north, c.east + (100 - c.width / 2) / c.scale, c.scale]"""
    pointed = browser.run(under)
    box = browser.run(
        "const b = document.getElementById('plan').getBoundingClientRect(); return [b.x, b.y]"
    )
    turn = {
        "type": "scroll",
        "x": round(box[0]) + 100,
        "y": round(box[1]) + 200,
        "deltaX": 0,
        "deltaY": -300,
    }
    browser.act({"type": "wheel", "id": "wheel", "actions": [turn]})
    browser.until("return flotilla.plan.camera.scale > arguments[0]", pointed[2])
    assert browser.run(under)[:2] == pytest.approx(pointed[:2], abs=2.0 / pointed[2])


def test_two_fingers_zoom(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    # the camera may follow the fleet until the very moment of the touch
    browser.run("""const { camera, canvas } = flotilla.plan;
      const note = () => { window.touched = camera.scale; };
      canvas.addEventListener('pointerdown', note, { capture: true });""")
    fingers = []
    for name, begin, end in (("one", 300, 200), ("other", 400, 500)):
        moves = [
            {"type": "pointerMove", "x": begin, "y": 300},
            {"type": "pointerDown", "button": 0},
            {"type": "pointerMove", "x": end, "y": 300, "duration": 50},
            {"type": "pause", "duration": 100},
            {"type": "pointerUp", "button": 0},
        ]
        touch = {"pointerType": "touch"}
        fingers.append({"type": "pointer", "id": name, "parameters": touch, "actions": moves})
    browser.act(*fingers)
    browser.until("return flotilla.plan.camera.scale > 2.9 * window.touched")
    share = browser.run("return flotilla.plan.camera.scale / window.touched")
    assert share == pytest.approx(3.0, rel=0.02)
