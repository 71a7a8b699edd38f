# SPDX-License-Identifier: MIT
"""The replay page in Chromium, opened as a file."""

import math
from pathlib import Path

import numpy as np
import pytest

from sil.lockstep import metrics
from sil.plant.hull import Array
from sil.view import history, page
from sil.view.history import Boat, numbers
from tests.sil.view.browser import Browser
from tests.sil.view.live_page import CARD

DURATION_S = 100.0
AT = "return flotilla.shown.vessels.find((v) => v.id === arguments[0])"


def trace(step_s: float = 1.0) -> dict[str, Array]:
    """Two boats and a virtual leader on circles; headings run through ±π."""
    t_s = np.arange(0.0, DURATION_S + 0.5 * step_s, step_s)
    angle = 0.1 * t_s
    leader = np.stack([20.0 * np.sin(angle), -20.0 * np.cos(angle), metrics.wrap(angle)], axis=-1)
    offset_m = np.array([[0.0, 0.0], [-3.0, 2.0]])
    eta = np.stack([leader, leader, leader + np.array([-3.0, 4.0, 0.0])], axis=1)
    nu = np.tile([2.0, 0.0, 0.1], (*eta.shape[:2], 1))
    error = metrics.formation_error(eta, [0, 1], offset_m)
    thrust = np.stack([np.stack([angle, -angle], axis=-1)] * 2, axis=1)
    return {"t_s": t_s, "eta": eta, "nu": nu, "error": error, "thrust": thrust}


def replayed(
    browser: Browser, folder: Path, run: dict[str, Array] | None = None
) -> dict[str, Array]:
    """Opens the page of a run."""
    run = trace() if run is None else run
    told = history.of_trace(run, "a run", [Boat(1, 100, 1.2, (-15.0, 20.0)), Boat(2, 1)])
    boat = told["vessels"][1]
    boat["states"] = [[0.0, "HOLD"], [10.0, "FORMATION"], [60.0, "COAST"]]
    boat["held"] = [[60.0, ["leader lost or origin unknown"]]]
    boat["texts"] = [[61.0, "leader is lost"]]
    boat["severities"] = [[61.0, 3]]
    path = folder / "run.html"
    path.write_text(page.page_with(told, "a run"), encoding="utf-8")
    standing(browser, path)
    return run


def standing(browser: Browser, path: Path) -> None:
    """Open a replay's page with preference for reduced motion."""
    browser.still()
    browser.open(path.as_uri())
    browser.until("return flotilla.plots !== null && flotilla.shown !== null")


def seek(browser: Browser, t_s: float) -> None:
    script = """const at = document.getElementById('at'); at.value = arguments[0];
      at.dispatchEvent(new Event('input'))"""
    browser.run(script, t_s)
    browser.until("return Math.abs(flotilla.shown.t_s - arguments[0]) < 1e-3", t_s)


@pytest.mark.parametrize("t_s", [0.0, 17.0, 31.0, 99.0, 100.0])
def test_boats_are_where_the_run_had_them(browser: Browser, tmp_path: Path, t_s: float) -> None:
    run = replayed(browser, tmp_path)
    seek(browser, t_s)
    k = int(t_s)
    for agent, number in enumerate((100, 1, 2)):
        shown = browser.run(AT, number)
        wanted = [*run["eta"][k, agent], *run["nu"][k, agent, :2]]
        names = ("x_m", "y_m", "psi_rad", "u_mps", "v_mps")
        assert [shown[name] for name in names] == pytest.approx(wanted, abs=1e-5)
    follower = browser.run(AT, 2)
    assert follower["error_m"] == pytest.approx(2.0, abs=1e-5)
    assert follower["thrust_N"] == pytest.approx(list(run["thrust"][k, 1]), abs=1e-5)
    slot = run["eta"][k, 1, :2] + [-3.0, 2.0]
    assert follower["slot"] == pytest.approx(list(slot), abs=1e-5)


def test_between_samples_boats_are_between_also_where_the_heading_wraps(
    browser: Browser, tmp_path: Path
) -> None:
    run = replayed(browser, tmp_path)
    (wraps,) = np.flatnonzero(np.abs(np.diff(run["eta"][:40, 1, 2])) > math.pi)
    seek(browser, float(wraps) + 0.5)
    shown = browser.run(AT, 1)
    middle = run["eta"][wraps : wraps + 2, 1, :2].mean(axis=0)
    assert [shown["x_m"], shown["y_m"]] == pytest.approx(list(middle), abs=1e-4)
    psi = 0.1 * (wraps + 0.5)
    assert math.cos(shown["psi_rad"] - psi) == pytest.approx(1.0, abs=1e-6)


def test_card_has_the_state_at_that_time_and_its_reason(browser: Browser, tmp_path: Path) -> None:
    replayed(browser, tmp_path)
    browser.run(f"{CARD} card.querySelector('button').click()", "Boat 1")
    words = """return ['.state', '.held', '.said', '.follows'].map((place) =>
      document.querySelector('[aria-label="Boat 1"] ' + place).textContent)"""
    for t_s, wanted in (
        (5.0, ["HOLD", "", ""]),
        (10.0, ["FORMATION", "", ""]),
        (60.5, ["COAST", "leader lost or origin unknown", ""]),
        (99.0, ["COAST", "leader lost or origin unknown", "“leader is lost” 38 s ago"]),
    ):
        seek(browser, t_s)
        browser.until(f"{words}.join('|') === arguments[0]", "|".join([*wanted, "follows leader"]))


def test_card_has_the_escs_telemetry(browser: Browser, tmp_path: Path) -> None:
    told = history.of_trace(trace(), "a run", [Boat(1, 100), Boat(2, 1)])
    samples = numbers(told["t_s"]).size
    rpm = {"port_rpm": np.linspace(0.0, -1000.0, samples), "stbd_voltage_V": np.full(samples, 23.5)}
    told["vessels"][1] |= {name: history.column(values) for name, values in rpm.items()}
    path = tmp_path / "run.html"
    path.write_text(page.page_with(told, "a run"), encoding="utf-8")
    standing(browser, path)
    seek(browser, 25.0)
    rows = f"""{CARD} return [...card.querySelectorAll('tbody tr')].map((row) =>
      [...row.querySelectorAll('.esc:not([hidden])')].map((cell) => cell.textContent))"""
    choose = f"{CARD} card.querySelector('button').click()"
    browser.run(choose, "Boat 1")
    # current, temperature and errors, which nobody tells, have no column
    unknown = "unknown"
    found = rows.replace("return", "const found =")
    browser.until(f"{found}; return found[0].some(Boolean)", "Boat 1")
    assert browser.run(rows, "Boat 1") == [["−250", unknown], [unknown, "23.5"]]
    browser.run(choose, "Boat 2")
    browser.until(f"{CARD} return card.querySelector('table').hidden === false", "Boat 2")
    assert browser.run(rows, "Boat 2") == [[], []]


def test_replay_begins_by_itself_at_four_times(browser: Browser, tmp_path: Path) -> None:
    replayed(browser, tmp_path)
    browser.size(1200, 800)
    browser.run("window.begin = performance.now(); location.reload()")
    t_s, took_ms = browser.until("""return window.flotilla?.shown?.t_s > 6
      && [flotilla.shown.t_s, performance.now()]""")
    assert browser.run("return document.getElementById('speed').value") == "4"
    # the page's clock begins with its loading
    assert t_s <= 4.0 * took_ms / 1000.0


def test_events_are_listed_and_one_that_is_chosen_is_gone_to(
    browser: Browser, tmp_path: Path
) -> None:
    replayed(browser, tmp_path)
    listed = """return [...document.querySelectorAll('#events li')].map((row) =>
      [...row.querySelectorAll('span, b')].map((part) => part.textContent))"""
    assert browser.until(f"{listed}.filter((row) => row.length)") == [
        ["10.0 s", "Boat 1", "FORMATION"],
        ["60.0 s", "Boat 1", "COAST"],
        ["60.0 s", "Boat 1", "leader lost or origin unknown"],
        ["61.0 s", "Boat 1", "“leader is lost”"],
    ]
    assert browser.run("return flotilla.source.events.at(-1).colour") == "bad"
    browser.run("document.querySelectorAll('#events button')[1].click()")
    browser.until("return Math.abs(flotilla.shown.t_s - 60) < 0.01")
    current = "return document.querySelector('#events [aria-current]')?.textContent"
    assert "leader lost" in browser.until(current)
    # marks lie under the slider where the slider has that time
    marks = """const track = document.getElementById('event-track');
      const { data } = track.getContext('2d').getImageData(0, track.height - 1, track.width, 1);
      return [...Array(track.width).keys()].filter((i) => data[4 * i + 3] > 0)
        .map((i) => 100 * i / track.width)"""
    found = browser.run(marks)
    assert found and all(min(abs(at - t_s) for t_s in (10, 60, 61)) < 1.0 for at in found)
    assert all(min(abs(at - t_s) for at in found) < 1.0 for t_s in (10, 60, 61))


def test_replay_plays_at_its_speed_and_stops_at_the_end(browser: Browser, tmp_path: Path) -> None:
    replayed(browser, tmp_path)
    begin = """document.getElementById('speed').value = '16'; window.begin = performance.now();
      document.getElementById('pause').click()"""
    browser.run(begin)
    at_s, took_ms = browser.until(
        "return flotilla.shown.t_s > 20 && [flotilla.shown.t_s, performance.now() - window.begin]"
    )
    assert at_s <= 16.0 * took_ms / 1000.0 + 1e-6
    browser.until("return flotilla.shown.t_s === 100")
    browser.until("return document.getElementById('pause').textContent === 'Play'")
    browser.press(" ")
    browser.until("return flotilla.shown.t_s < 90")


def test_keys_seek_and_play(browser: Browser, tmp_path: Path) -> None:
    replayed(browser, tmp_path)
    browser.run("document.activeElement.blur()")
    for key, t_s in (
        ("\ue014", 1.0),
        ("\ue014", 2.0),
        ("\ue012", 1.0),
        ("\ue010", 100.0),
        ("\ue011", 0.0),
    ):
        browser.press(key)
        browser.until("return flotilla.shown.t_s === arguments[0]", t_s)
    browser.press(" ")
    browser.until("return document.getElementById('pause').textContent === 'Pause'")


def test_click_into_a_plot_goes_to_that_time_and_every_plot_marks_it(
    browser: Browser, tmp_path: Path
) -> None:
    replayed(browser, tmp_path)
    browser.until("return document.querySelectorAll('.cursor').length === 3")
    script = """const { canvas, scales } = flotilla.plots.charts.thrust;
      const box = canvas.getBoundingClientRect();
      return [Math.round(box.x + scales.x.getPixelForValue(50)), Math.round(box.y + 40)]"""
    x, y = browser.until(
        "return flotilla.plots.charts.thrust.data.datasets.length && (() => {" + script + "})()"
    )
    click = [
        {"type": "pointerMove", "x": x, "y": y},
        {"type": "pointerDown", "button": 0},
        {"type": "pointerUp", "button": 0},
    ]
    browser.act({"type": "pointer", "id": "mouse", "actions": click})
    browser.until("return Math.abs(flotilla.shown.t_s - 50) < 2")
    marked = """return Object.values(flotilla.plots.charts).map(({ canvas, scales }) =>
      parseFloat(canvas.parentElement.querySelector('.cursor').style.left)
        - scales.x.getPixelForValue(flotilla.shown.t_s))"""
    assert browser.run(marked) == pytest.approx([0.0] * 3, abs=1.0)


def test_plots_hold_the_whole_run_and_the_limits(browser: Browser, tmp_path: Path) -> None:
    replayed(browser, tmp_path)
    browser.until("return flotilla.plots.charts.error.data.datasets.length === 2")
    script = """const { error, thrust, speed } = flotilla.plots.charts;
      const lines = [error, thrust, speed].map((chart) => chart.data.datasets.length);
      const { y } = thrust.scales, { x } = error.scales;
      return [lines, y.min, y.max, [x.min, x.max]]"""
    lines, low, high, span = browser.run(script)
    assert lines == [2, 4, 3] and span == [0.0, DURATION_S]
    assert low <= -15.0 and high >= 20.0
    note = browser.run("return document.getElementById('thrust-note').textContent")
    assert note == "stbd dashed, limits −15, 20"


def test_run_that_diverged_is_shown_up_to_there(browser: Browser, tmp_path: Path) -> None:
    run = trace()
    run["eta"][50:, 1] = np.nan
    run["error"][50:, 0] = np.inf
    replayed(browser, tmp_path, run)
    for t_s in (40.0, 49.5, 80.0):
        seek(browser, t_s)
    assert browser.run(AT, 1)["x_m"] is None
    assert browser.run(AT, 2)["x_m"] is not None


def test_an_empty_history_gives_an_empty_page(browser: Browser, tmp_path: Path) -> None:
    nothing = {"title": "nothing", "t_s": history.column([]), "vessels": []}
    path = tmp_path / "page.html"
    path.write_text(page.page_with(nothing, "nothing"), encoding="utf-8")
    browser.open(path.as_uri())
    browser.until("return flotilla.plots !== null && flotilla.shown !== null")
    assert not browser.run("return document.getElementById('nothing').hidden")


@pytest.mark.parametrize("width", [328, 360])
def test_replay_fits_a_phone_also_inside_a_report(
    browser: Browser, tmp_path: Path, width: int
) -> None:
    browser.size(width, 740)
    replayed(browser, tmp_path)
    assert browser.run("return document.documentElement.scrollWidth") <= width
    tools = "return document.getElementById(arguments[0]).getBoundingClientRect().right"
    assert browser.run(tools, "measure") <= browser.run(tools, "plan-box")


def test_a_boat_of_unknown_state_is_in_trouble(browser: Browser, tmp_path: Path) -> None:
    told = history.of_trace(trace(), "a run")
    told["vessels"][1]["states"] = [[0.0, "FORMATION"], [50.0, None], [80.0, "FORMATION"]]
    path = tmp_path / "run.html"
    path.write_text(page.page_with(told, "a run"), encoding="utf-8")
    standing(browser, path)
    line = "return document.getElementById('line-troubles').textContent === arguments[0]"
    for t_s, wanted in ((40.0, "none"), (60.0, "1"), (90.0, "none")):
        seek(browser, t_s)
        browser.until(line, f"{wanted} in trouble")


def test_a_silent_boat_has_no_line_in_the_plots(browser: Browser, tmp_path: Path) -> None:
    told = history.of_trace(trace(), "a run")
    ages = np.maximum(0.0, history.numbers(told["t_s"]) - 40.0)
    told["vessels"][1]["link_age_s"] = history.column(ages)
    path = tmp_path / "run.html"
    path.write_text(page.page_with(told, "a run"), encoding="utf-8")
    browser.open(path.as_uri())
    errors = "return [...flotilla.source.track(arguments[0]).columns.error_m].map(Number.isFinite)"
    assert browser.run(errors, "1") == [t_s <= 45.0 for t_s in range(101)]
    assert browser.run(errors, "2") == [True] * 101
