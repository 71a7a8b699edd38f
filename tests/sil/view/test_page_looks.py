# SPDX-License-Identifier: MIT
"""The live page's look on a phone, in light and dark, its accessibility and its speed."""

from typing import Any

import pytest

from tests.sil.view.browser import Browser
from tests.sil.view.feeder import Feeder, boat, fleet, frame
from tests.sil.view.live_page import shown

ROLES = ("button", "combobox", "slider", "checkbox", "tab", "image")


def test_plan_has_the_colours_of_the_boats_on_it(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    script = """const plan = document.getElementById('plan');
      const { data } = plan.getContext('2d').getImageData(0, 0, plan.width, plan.height);
      const found = new Set();
      for (let i = 0; i < data.length; i += 4) {
        found.add((data[i] << 16) | (data[i + 1] << 8) | data[i + 2]);
      }
      return [0x0072b2, 0xd55e00, 0x009e73, 0xcc79a7].map((colour) => found.has(colour))"""
    assert browser.run(script) == [True] * 4


def test_first_paint_is_within_a_second(browser: Browser, four: Feeder) -> None:
    """Judge the fastest of some loads, as other processes may use this machine."""
    painted_ms = []
    for _ in range(5):
        shown(browser, four)
        script = "return performance.getEntriesByName('first-contentful-paint')[0]?.startTime"
        painted_ms.append(browser.until(script))
        if painted_ms[-1] < 1000.0:
            break
    assert min(painted_ms) < 1000.0


def test_page_fits_a_phone(browser: Browser, four: Feeder) -> None:
    browser.size(360, 740)
    shown(browser, four)
    assert browser.run("return document.documentElement.scrollWidth") <= 360
    plan = browser.run(
        "const b = document.getElementById('plan').getBoundingClientRect(); "
        "return [b.top, b.bottom]"
    )
    assert plan[0] < 200 and plan[1] < 740
    first = "return document.querySelector('#cards .state').getBoundingClientRect().top"
    assert plan[1] < browser.run(first) < 740
    order = """return ['plan-box', 'cards', 'transport', 'plots'].map((id) =>
      document.getElementById(id).getBoundingClientRect().top)"""
    tops = browser.run(order)
    assert tops == sorted(tops)


@pytest.mark.parametrize("dark", [False, True], ids=["light", "dark"])
def test_texts_are_read_in_light_and_dark(browser: Browser, four: Feeder, dark: bool) -> None:
    """Contrast by WCAG 2 of every text on the page: at least 4.5."""
    browser.size(1200, 800, dark=dark)
    lost = {"state": "COAST", "held": ["leader lost or origin unknown"], "text": "leader is lost"}
    silent = {"link_age_s": 9.0}
    changes: list[dict[str, Any]] = [
        {},
        {},
        lost,
        silent,
        {"state": "MANUAL"},
        {"state": "DISARMED"},
    ]
    many = [*changes, {"state": "FAULT"}, {"state": "TEST"}, {"state": "HOLD"}]
    shown(browser, four)
    boats = list(enumerate(many, start=1))
    text = (1, 20.0, 3, 2, "leader is lost")
    four.frames = lambda t_s: frame(t_s, [boat(n, t_s, **c) for n, c in boats], text)
    browser.until("return document.querySelectorAll('.card').length === 9")
    browser.until("return document.querySelectorAll('#events .told').length > 3")
    script = """const rgb = (text) => text.match(/[0-9.]+/g).slice(0, 3).map((x) => x / 255);
      const linear = (x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
      const light = (colour) => rgb(colour).map(linear)
        .reduce((sum, x, i) => sum + [0.2126, 0.7152, 0.0722][i] * x, 0);
      const paperOf = (place) => {
        for (let at = place; at; at = at.parentElement) {
          const colour = getComputedStyle(at).backgroundColor;
          if (!/rgba\\(.*, 0\\)/.test(colour)) return colour;
        }
      };
      const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), found = [];
      while (texts.nextNode()) {
        const place = texts.currentNode.parentElement;
        if (!texts.currentNode.data.trim() || !place.checkVisibility() || place.disabled) continue;
        const ink = light(getComputedStyle(place).color), paper = light(paperOf(place));
        const contrast = (Math.max(ink, paper) + 0.05) / (Math.min(ink, paper) + 0.05);
        found.push([contrast, texts.currentNode.data]);
      }
      return found"""
    contrasts = browser.run(script)
    assert len(contrasts) > 80 and [found for found in contrasts if found[0] < 4.5] == []
    paper = browser.run("return getComputedStyle(document.body).backgroundColor")
    assert (paper == "rgb(255, 255, 255)") is not dark


def test_every_control_has_a_name(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    for page in ("fleet", "what-if"):
        browser.run("document.getElementById(arguments[0]).click()", f"tab-{page}")
        nodes = browser.devtools("Accessibility.getFullAXTree")["nodes"]
        controls = [
            n for n in nodes if n.get("role", {}).get("value") in ROLES and not n["ignored"]
        ]
        unnamed = [n for n in controls if not n.get("name", {}).get("value")]
        assert (
            len(controls) > 8
            and [n["role"]["value"] for n in unnamed if n["role"]["value"] != "MenuListPopup"] == []
        )


def test_twenty_boats_are_not_drawn_more_often_than_ten_times_a_second(
    browser: Browser, four: Feeder
) -> None:
    shown(browser, four, fleet(20))
    browser.until("return flotilla.plots !== null")
    count = """const count = (thing) => { const draw = thing.draw.bind(thing); thing.drawn = 0;
      thing.draw = (...all) => { thing.drawn += 1; draw(...all); }; };
      count(flotilla.plan); count(flotilla.plots); window.since = performance.now();"""
    browser.run(count)
    browser.until("return flotilla.plan.drawn >= 10")
    drawn, plotted, took_ms = browser.run(
        "return [flotilla.plan.drawn, flotilla.plots.drawn, performance.now() - window.since]"
    )
    assert drawn <= took_ms / 90.0 + 2
    assert plotted <= took_ms / 990.0 + 2
