# SPDX-License-Identifier: MIT
"""Plans, fences and rally points on the page in Chromium, live and replayed."""

import json
import math
from pathlib import Path

import pytest

from sil.cli.main import main as flotilla
from sil.view import page
from sil.view.recorded import history_of_run
from tests.sil.view.browser import Browser
from tests.sil.view.feeder import Feeder, boat, frame
from tests.sil.view.test_page_replay import seek, standing

PLAN = {
    "way": [[-4.0, 2.0, 1], [-4.0, 5.0, 2], [30.0, 30.0, 4]],
    "fence": [
        {"inside": True, "points": [[-20.0, -20.0], [50.0, -20.0], [50.0, 50.0], [-20.0, 50.0]]},
        {"inside": False, "centre": [20.0, 25.0], "radius_m": 4.0},
    ],
    "rally": [[5.0, -10.0]],
}
SAID = "return document.querySelector('canvas[aria-label]').getAttribute('aria-label')"


def with_plans(t_s: float, plans: object, item: object = 2) -> str:
    told = json.loads(frame(t_s, [boat(1, 0.0, state="AUTO", item=item), boat(2, 0.0)]))
    return json.dumps({**told, "plans": plans})


def seen(browser: Browser, feeder: Feeder, plans: object, item: object = 2) -> str:
    feeder.frames = lambda t_s: with_plans(t_s, plans, item)
    browser.open(feeder.url)
    browser.until("return flotilla.shown?.vessels.length === 2 && flotilla.source.frames > 3")
    return str(browser.until(SAID))


def test_a_live_page_draws_the_plan(browser: Browser, four: Feeder) -> None:
    told = seen(browser, four, {"1": PLAN})
    assert "Boat 1 AUTO (plan of 3 waypoints, waypoint 2 ahead; fence of 2 parts; 1 rally" in told
    assert "Boat 2 FORMATION" in told and told.count("plan of") == 1


def test_the_waypoint_ahead_is_filled_with_its_boats_colour(browser: Browser, four: Feeder) -> None:
    """The dot is drawn at the waypoint's pixels, and gone with the plan."""
    pixel = """const [x, y] = flotilla.plan.camera.at(-4, 5), canvas = flotilla.plan.canvas;
      return [...canvas.getContext('2d').getImageData(x, y, 1, 1).data].slice(0, 3)"""
    blue = """const [r, g, b] = (() => {%s})(); return b > 150 && r < 60"""
    browser.size(1280, 800)
    seen(browser, four, {"1": PLAN}, item=2)
    browser.until(blue % pixel)
    four.frames = lambda t_s: with_plans(t_s, {"1": PLAN}, 4)
    browser.until(f"return !(() => {{ {blue % pixel} }})()")
    four.frames = lambda t_s: with_plans(t_s, {"1": PLAN}, 2)
    browser.until(blue % pixel)
    four.frames = lambda t_s: with_plans(t_s, {})
    browser.until(f"return !(() => {{ {blue % pixel} }})()")


def test_the_view_can_hold_fleet_and_plans(browser: Browser, four: Feeder) -> None:
    browser.size(1280, 800)
    seen(browser, four, {"1": PLAN})
    near = browser.run("return flotilla.plan.camera.scale")
    browser.until("""const centre = document.getElementById('centre'); centre.value = 'plans';
      centre.dispatchEvent(new Event('change'));
      return flotilla.plan.camera.mode === 'plans'""")
    last = """const c = flotilla.plan.camera, [x, y] = c.at(30, 30);
      return x > 0 && x < c.width && y > 0 && y < c.height"""
    browser.until(last)
    assert browser.run("return flotilla.plan.camera.scale") < 0.5 * near


@pytest.mark.parametrize(
    "plans", [None, 7, [], {"1": None}, {"1": {"way": [[1]], "fence": [None, {}], "rally": 3}}]
)
def test_an_invalid_plan_is_left_out(browser: Browser, four: Feeder, plans: object) -> None:
    assert "plan of" not in seen(browser, four, plans, item="x")


def test_a_replayed_run_shows_the_plan_of_the_boat_that_leads(
    browser: Browser, tmp_path: Path
) -> None:
    out = tmp_path / "lead"
    assert flotilla(["run", "lead", "--set", "duration_s=90", "--out", str(out)]) == 0
    told = history_of_run(out)
    leader, one, two = told["vessels"][:3]
    ((at_s, plan),) = one["plans"]
    assert at_s == 0.0 and [number for *_, number in plan["way"]] == [1, 2, 3, 4, 5]
    assert math.dist(plan["way"][1][:2], (40.0, 12.0)) < 0.02
    assert [item for _, item in one["items"]] == [0, 1, 2]
    assert two["plans"] == [] == leader["plans"]
    path = tmp_path / "run.html"
    path.write_text(page.page_with(told, "a run"), encoding="utf-8")
    standing(browser, path)
    seek(browser, 75.0)
    browser.until(f"{SAID.replace('return', 'return 0 ||')}.includes('waypoint 2 ahead')")
    cards = "return [...document.querySelectorAll('.card')].map((c) => c.ariaLabel)"
    names = ["Boat 1", "Boat 2", "Boat 3", "Boat 4", "Plan of boat 1"]
    assert browser.run(cards) == names
