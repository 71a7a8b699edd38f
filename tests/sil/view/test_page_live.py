# SPDX-License-Identifier: MIT
"""The live page in Chromium, with a made-up fleet."""

import json
from typing import Any

import pytest

from tests.each_push import few
from tests.sil.view.browser import Browser
from tests.sil.view.feeder import Feeder, boat, feeding, fleet, frame, leader
from tests.sil.view.live_page import CARD, LIVE, shown, word

GARBAGE: list[str | bytes] = [
    "",
    "null",
    "{}",
    "[1, 2",
    '{"t_s": "soon", "vessels": []}',
    '{"t_s": 1, "vessels": {}}',
    b"\x00\xff\xfd",
    '{"t_s": 1e999, "vessels": []}',
]
ODD: list[Any] = [None, 7, "boat", [], {}, {"id": "one"}, {"id": 1.5}]


def places(browser: Browser) -> dict[str, list[float]]:
    """North and east of every vessel shown, by name."""
    script = """return Object.fromEntries(flotilla.shown.vessels.map((v) =>
      [v.key, flotilla.plan.camera.at(v.x_m, v.y_m).concat([v.x_m, v.y_m])]))"""
    found: dict[str, list[float]] = browser.run(script)
    return found


def test_four_boats_move_on_the_plan_and_have_a_card_each(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    before = places(browser)
    assert set(before) == {"1", "2", "3", "4", "100"}
    browser.until(
        "return flotilla.shown.t_s > arguments[0]", browser.run("return flotilla.shown.t_s") + 1
    )
    after = places(browser)
    assert all(after[key][2:] != before[key][2:] for key in before)
    cards = browser.run(
        "return [...document.querySelectorAll('.card h3')].map((c) => c.textContent)"
    )
    assert cards == ["Boat 1", "Boat 2", "Boat 3", "Boat 4", "Leader 100"]
    label = browser.run("return document.getElementById('plan').getAttribute('aria-label')")
    assert "Boat 3 FORMATION" in label


def test_trail_reaches_the_boat_in_every_frame(browser: Browser, four: Feeder) -> None:
    gaps = """const { camera, canvas } = flotilla.plan, { t, columns } = flotilla.source.track('1');
      const ctx = canvas.getContext('2d'), water = ctx.getImageData(2, 60, 1, 1).data.join();
      const pixel = (i) => camera.at(columns.x_m[i], columns.y_m[i]).map(Math.floor);
      const bare = (i) => ctx.getImageData(...pixel(i), 1, 1).data.join() === water;
      return t.map((_, i) => i).filter((i) => i > 0 && t[i] < flotilla.shown.t_s && bare(i))"""
    shown(browser, four)
    # hulls, the leader's ring and names have an edge of water, also where another boat's trail is
    browser.run("for (const f of ['drawHull', 'drawVirtual', 'write']) window[f] = () => {}")
    begin_s = browser.run("return flotilla.shown.t_s")
    browser.until("return flotilla.source.track('1').t.length > 15")
    # on a busy machine frames are heard long before the first of them is drawn without hulls
    browser.until("return flotilla.shown.t_s > arguments[0]", begin_s)
    looks = 0
    while looks < 20 or browser.run("return flotilla.shown.t_s") < begin_s + 2.5:
        assert browser.run(gaps) == []
        looks += 1


def test_nothing_but_the_page_and_its_socket_is_asked_for(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    asked = [url for url in browser.asked_for() if url.startswith(("http", "ws"))]
    assert asked == [four.url, f"{four.url.replace('http', 'ws')}live"]


def test_lost_leader_is_seen_with_the_reason(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    assert word(browser, "Boat 2", ".state") == "FORMATION"
    lost = {
        "held": ["leader lost or origin unknown"],
        "text": "leader is lost",
        "leader_age_s": 1.2,
    }
    lost["text_age_s"] = 12.0
    for state in ("COAST", "HOLD"):
        four.frames = lambda t_s, state=state: frame(
            t_s, [leader(t_s), boat(1, t_s), boat(2, t_s, state=state, **lost)]
        )
        browser.until(
            f"{CARD} return card.querySelector('.state').textContent === '{state}'", "Boat 2"
        )
        assert word(browser, "Boat 2", ".held") == "leader lost or origin unknown"
    assert word(browser, "Boat 2", ".said") == "“leader is lost” 12 s ago"
    assert word(browser, "Boat 1", ".state") == "FORMATION"


def test_vessel_that_is_silent_is_greyed_and_one_that_is_gone_has_no_card(
    browser: Browser, four: Feeder
) -> None:
    shown(browser, four)
    four.frames = lambda t_s: frame(t_s, [boat(1, t_s), boat(2, t_s, link_age_s=12.3)])
    browser.until(f"{CARD} return card.classList.contains('stale')", "Boat 2")
    assert word(browser, "Boat 2", ".held") == "silent for 12 s, last heard in FORMATION"
    assert word(browser, "Boat 2", ".state") == "unknown"
    facts = f"{CARD} return [...card.querySelectorAll('dd')].map((d) => d.textContent)"
    known = ["12 s ago"]
    assert sorted(set(browser.run(facts, "Boat 2"))) == [*known, "unknown"]
    assert browser.run("return document.querySelectorAll('.card').length") == 2
    four.frames = lambda t_s: frame(t_s, [])
    browser.until("return !document.getElementById('nothing').hidden")
    assert browser.run("return document.querySelectorAll('.card').length") == 0


def test_line_on_top_counts_boats_in_their_slots_and_in_trouble(
    browser: Browser, four: Feeder
) -> None:
    far = {"error_m": 9.5, "in_slot": 0.0}
    lost = {"state": "COAST", "held": ["leader lost or origin unknown"], "in_slot": 0.0}
    near = {"error_m": 0.02, "in_slot": 1.0}
    mixed: list[tuple[int, dict[str, Any]]] = [
        (1, near),
        (2, near),
        (3, far),
        (4, {**near, **lost}),
        (5, {"link_age_s": 9.0}),
    ]
    four.frames = lambda t_s: frame(t_s, [leader(t_s), *(boat(n, t_s, **c) for n, c in mixed)])
    shown(browser, four)
    line = "return [...document.querySelectorAll('#fleet-line > *')].map((x) => x.textContent)"
    assert browser.until(f"{line}.every((text) => text) && (() => {{ {line} }})()") == [
        "5 boats, 2 in their slots",
        "2 in trouble",
        "3 FORMATION, 1 COAST, 1 unknown",
        "farthest from its slot: boat 3, 9.50 m",
        "table 3, boat 1 leads",
    ]
    # a card with the reason for those in trouble, a row for the others
    whole = "return [...document.querySelectorAll('.whole')].map((c) => c.ariaLabel)"
    assert browser.run(whole) == ["Boat 4", "Boat 5"]
    assert browser.run("return document.querySelectorAll('.row').length") == 4


def test_boats_nearer_than_a_hull_are_in_trouble(browser: Browser, four: Feeder) -> None:
    at = {1: (0.0, 0.0), 2: (0.0, 0.6), 3: (0.0, 1.7)}
    four.frames = lambda t_s: frame(
        t_s, [boat(n, t_s, x_m=x, y_m=y, length_m=1.0) for n, (x, y) in at.items()]
    )
    shown(browser, four)
    browser.until(f"{CARD} return card?.querySelector('.held')?.textContent", "Boat 1")
    near = "0.600 m from boat {}: nearer than a hull's length"
    assert word(browser, "Boat 1", ".held") == near.format(2)
    assert word(browser, "Boat 2", ".held") == near.format(1)
    assert browser.run("return document.querySelectorAll('.whole').length") == 2


def test_columns_without_values_are_hidden(browser: Browser, four: Feeder) -> None:
    bare: dict[str, Any] = {"battery_V": None, "thrust_N": None, "limits_N": None, "escs": []}
    shown(browser, four, lambda t_s: frame(t_s, [boat(n, t_s, **bare) for n in (1, 2)]))
    heads = """return [...document.querySelectorAll('.heads > span')].filter((x) =>
      x.checkVisibility()).map((x) => x.textContent).filter(Boolean)"""
    browser.until(f"return (() => {{ {heads} }})().length > 0")
    assert browser.run(heads) == ["from slot", "speed"]
    browser.until("return document.getElementById('plot-thrust').closest('figure').hidden")
    assert not browser.run("return document.getElementById('plot-speed').closest('figure').hidden")
    four.frames = fleet(2)
    browser.until(f"return (() => {{ {heads} }})().length === 3")
    browser.until("return !document.getElementById('plot-thrust').closest('figure').hidden")


def test_a_value_that_is_no_longer_sent_is_unknown(browser: Browser, four: Feeder) -> None:
    shown(browser, four, lambda t_s: frame(t_s, [boat(1, t_s), boat(2, t_s)]))
    four.frames = lambda t_s: frame(
        t_s, [boat(1, t_s, battery_V=None, u_mps=None, state=None), boat(2, t_s)]
    )
    browser.until(f"{CARD} return card.classList.contains('trouble')", "Boat 1")
    assert word(browser, "Boat 1", ".held") == "state unknown: no HEARTBEAT for more than 5 s"
    facts = f"""{CARD} return Object.fromEntries([...card.querySelectorAll('dl > div')].map((row) =>
      [...row.children].map((x) => x.textContent)))"""
    told = browser.run(facts, "Boat 1")
    assert told["battery"] == told["speed"] == "unknown" and told["heading"].endswith("°")


def test_a_boat_without_conditions_and_one_whose_id_is_anothers_too_are_in_trouble(
    browser: Browser, four: Feeder
) -> None:
    lost = {"state": "HOLD", "conditions_lost_s": 41.0}
    shown(browser, four, lambda t_s: frame(t_s, [boat(1, t_s, **lost), boat(2, t_s, senders=2)]))
    browser.until(f"{CARD} return card?.classList.contains('trouble')", "Boat 1")
    assert word(browser, "Boat 1", ".held") == "conditions unknown for 41 s"
    assert word(browser, "Boat 2", ".held") == "two vessels use system id 2"


def test_a_mode_that_the_page_does_not_know_is_named(browser: Browser, four: Feeder) -> None:
    odd = {"state": None, "unknown_mode": 77}
    shown(browser, four, lambda t_s: frame(t_s, [boat(1, t_s, **odd), boat(2, t_s)]))
    browser.until(f"{CARD} return card?.classList.contains('trouble')", "Boat 1")
    why = "state unknown: its HEARTBEAT has custom_mode 77"
    assert word(browser, "Boat 1", ".held") == why


def test_silent_source_is_reported_in_red(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    assert browser.run("return document.getElementById('alarm').hidden")
    told = "nothing heard for 3 s: check that the boats have power"
    heard = {"address": "mcast:", "alarm": told, "bytes_per_s": 0}
    four.frames = lambda t_s: json.dumps({"t_s": t_s, "heard": heard, "vessels": []})
    browser.until("return !document.getElementById('alarm').hidden")
    script = """const place = document.getElementById('alarm');
      return [place.textContent, getComputedStyle(place).backgroundColor, place.role]"""
    assert browser.run(script) == [told, "rgb(179, 38, 30)", "alert"]


def test_events_are_listed_the_newest_first(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    told = "return [...document.querySelectorAll('#events .told')].map((x) => x.textContent)"
    lost = {"held": ["leader lost or origin unknown"], "state": "COAST", "text": "stopping"}
    texts = [
        (1, 19.0, 1, 6, "set out"),
        (2, 20.0, 2, 2, "leader is lost"),
        (3, 20.0, 2, 4, "coast"),
    ]
    four.frames = lambda t_s: frame(t_s, [boat(1, t_s), boat(2, t_s, **lost)], *texts)
    browser.until("return flotilla.source.events.length === 5")
    four.frames = lambda t_s: frame(t_s, [boat(1, t_s), boat(2, t_s, text="stopping")], *texts)
    browser.until("return flotilla.source.events.length === 7")
    browser.until("return document.querySelectorAll('#events .told').length === 7")
    assert browser.run(told) == [
        "nothing is missing any more",
        "FORMATION",
        "leader lost or origin unknown",
        "COAST",
        "“coast”",
        "“leader is lost”",
        "“set out”",
    ]
    colours = "return flotilla.source.events.slice(0, 3).map(({ colour }) => colour)"
    assert browser.run(colours) == ["calm", "bad", "warn"]
    # a page that is opened anew lists the texts from before
    shown(browser, four)
    browser.until("return flotilla.source.events.length === 3")


def test_a_paused_page_is_dimmed_and_still_reports_troubles(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    browser.press(" ")
    status = "document.getElementById('status').textContent"
    browser.until(f"return {status}.startsWith('paused for ')")
    at_s = browser.run("return flotilla.shown.t_s")
    assert browser.run("return document.body.classList.contains('cut')")
    told = "nothing heard for 3 s: check that the boats have power"
    fault = boat(2, 0.0, state="FAULT", link_age_s=0.0)
    four.frames = lambda t_s: json.dumps(
        {"t_s": t_s, "heard": {"alarm": told}, "vessels": [boat(1, t_s), fault]}
    )
    line = "document.getElementById('line-troubles').textContent"
    browser.until(f"return {line} === '1 in trouble'")
    browser.until("return document.getElementById('alarm').textContent === arguments[0]", told)
    browser.until(f"return {status} !== 'paused for 0 s'")
    assert browser.run("return flotilla.shown.t_s") == at_s
    browser.press(" ")
    browser.until("return !document.body.classList.contains('cut')")
    assert browser.until(f"{LIVE} && [flotilla.shown.vessels.length]") == [2]


def test_a_fault_is_read_out_and_in_the_title(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    browser.until("return document.title === 'Flotilla'")
    fault = {"state": "FAULT", "text": "FAULT: jump in navigation data"}
    four.frames = lambda t_s: frame(t_s, [boat(1, t_s), boat(2, t_s, **fault)])
    browser.until("return document.title === '1 in trouble · Flotilla'")
    browser.until("return document.getElementById('newest').textContent === 'Boat 2: FAULT'")
    live = "return ['line-troubles', 'newest'].map((id) => document.getElementById(id).ariaLive)"
    assert browser.run(live) == ["assertive", "polite"]
    four.frames = fleet(2)
    browser.until("return document.title === 'Flotilla'")


def test_two_clicks_measure_the_distance_between_them(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    browser.run("document.getElementById('nearer').click()")
    browser.run("document.getElementById('measure').click()")
    box = "const b = document.getElementById('plan').getBoundingClientRect(); return [b.x, b.y]"
    x, y = browser.run(box)
    scale = browser.run("return flotilla.plan.camera.scale")
    browser.click(x + 100, y + 200)
    browser.click(x + 300, y + 200)
    words = browser.run("return document.getElementById('measured').textContent")
    far, bearing = words.split(", bearing ")
    assert float(far.removesuffix(" m")) == pytest.approx(200.0 / scale, abs=2.0 / scale)
    assert bearing == "090°"
    browser.press("\ue00c")
    assert browser.run("return document.getElementById('measured').textContent") == ""


def test_map_is_moved_and_measured_by_keys(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    browser.run(
        "document.getElementById('nearer').click(); document.getElementById('plan').focus()"
    )
    browser.press("m")
    browser.press("\ue007")
    for _ in range(2):
        browser.press("\ue014")
    browser.press("\ue007")
    scale = browser.run("return flotilla.plan.camera.scale")
    words = browser.run("return document.getElementById('measured').textContent")
    far = float(words.split(" m")[0])
    assert far == pytest.approx(120.0 / scale, rel=0.01) and words.endswith("bearing 090°")


def test_page_shows_the_source_its_rate_and_its_damage(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    heard = browser.run("return document.getElementById('heard').textContent")
    assert heard == "mcast: · 12.3 kB/s · 5 vessels · 7 B damaged · 3 messages ignored"


def test_page_says_that_the_view_went_away_and_goes_on_when_it_is_back(browser: Browser) -> None:
    with feeding(fleet(2), begin_s=500.0) as feeder:
        shown(browser, feeder)
        port = feeder.port
    browser.until("return document.getElementById('status').className === 'bad'")
    assert browser.run("return document.body.classList.contains('cut')")
    with feeding(fleet(3), port):
        browser.until(LIVE)
        browser.until("return document.querySelectorAll('.card').length === 4")
        # the view counts from 0 again: earlier samples do not belong to this history
        assert browser.run("return flotilla.source.track('1').t[0] < 400")
    assert all("WebSocket connection" in text for text in browser.errors())
    browser.forget()


def test_connection_that_says_nothing_is_renewed_and_its_old_frame_stays_dimmed(
    browser: Browser, four: Feeder
) -> None:
    shown(browser, four)
    four.frames = lambda _: None
    connected = "flotilla.source.status[1].startsWith('connected')"
    cut = "document.body.classList.contains('cut')"
    assert browser.until(f"return {connected} && {cut} && [flotilla.source.cut]") == [True]
    assert sum(url.startswith("ws") for url in browser.asked_for()) > 1
    assert not browser.run("return document.getElementById('alarm').hidden")
    four.frames = fleet(4)
    browser.until(f"return !{cut} && !flotilla.source.cut")


@pytest.mark.parametrize("message", few(GARBAGE, GARBAGE[::3]), ids=range(len(GARBAGE)))
def test_garbage_is_counted_and_the_fleet_goes_on(
    browser: Browser, four: Feeder, message: str | bytes
) -> None:
    shown(browser, four)
    four.frames = lambda _: message
    browser.until("return flotilla.source.garbage > 0")
    four.frames = fleet(2)
    browser.until("return document.querySelectorAll('.card').length === 3")
    assert "frames not understood" in browser.until(
        "return document.getElementById('heard').textContent"
    )


def test_vessels_of_the_wrong_types_are_left_out_or_unknown(browser: Browser, four: Feeder) -> None:
    wrong = {name: ["x"] for name in boat(9, 0.0) if name != "id"}
    dots = {**boat(8, 0.0), "x_m": None, "psi_rad": "north", "slot": [1], "escs": [None, 3]}
    again = boat(7, 1.0)
    four.frames = lambda t_s: frame(t_s, [*ODD, {"id": 9, **wrong}, dots, again, again, {"id": 6}])
    shown(browser, four)
    cards = browser.run(
        "return [...document.querySelectorAll('.card h3')].map((c) => c.textContent)"
    )
    # the last one's list of one text is a list of what it lacks
    assert cards == ["Vessel 9", "Vessel 6", "Boat 7", "Boat 8"]


def test_boat_that_holds_can_be_played_with_as_it_is(browser: Browser, four: Feeder) -> None:
    held = {"held": ["jump in navigation data"], "state": "HOLD"}
    shown(browser, four, lambda t_s: frame(t_s, [boat(1, t_s), boat(2, t_s, **held)]))
    browser.run("document.getElementById('tab-what-if').click()")
    browser.run("document.querySelectorAll('#boats button')[1].click()")
    script = """const lost = [...document.querySelectorAll('#conditions input:not(:checked)')];
      return [document.querySelector('#verdict .state').textContent, lost.map((box) => box.id)]"""
    assert browser.run(script) == ["HOLD", ["met-own_steady"]]


def test_a_tile_that_failed_is_asked_for_again(browser: Browser, four: Feeder) -> None:
    shown(browser, four)
    browser.run("flotilla.chart.again_ms = 50; window.failed = flotilla.chart.tile('data:,none')")
    browser.until("return flotilla.chart.tile('data:,none') !== window.failed")


def test_hundred_vessels_are_shown(browser: Browser, four: Feeder) -> None:
    shown(browser, four, fleet(100))
    browser.until("return document.querySelectorAll('.card').length === 100")
    browser.until("return flotilla.plots.charts.error.data.datasets.length === 40")


def test_following_a_vessel_to_an_extreme_position_does_not_stop_the_page(
    browser: Browser, four: Feeder
) -> None:
    shown(browser, four)
    browser.run("""const select = document.getElementById('centre'); select.value = '1';
      select.dispatchEvent(new Event('change'))""")
    four.frames = lambda t_s: frame(t_s, [boat(1, t_s, x_m=1e30, y_m=-1e30)])
    browser.until("return flotilla.shown.vessels.length === 1 && flotilla.shown.vessels[0].x_m")
    at_s = browser.run("return flotilla.shown.t_s")
    browser.until("return flotilla.shown.t_s > arguments[0]", at_s + 0.5)


def test_old_places_and_lines_of_silent_boats_are_not_shown_as_new(browser: Browser) -> None:
    def frames(t_s: float) -> str:
        silent = boat(1, 0.0, link_age_s=9.0, place_age_s=9.0)
        return frame(t_s, [silent, boat(2, 0.0, place_age_s=9.0), boat(3, 0.0, place_age_s=0.1)])

    with feeding(frames) as feeder:
        shown(browser, feeder)
        browser.until("return flotilla.source.track('3').t.length > 2")
        old = "return flotilla.shown.vessels.map((v) => v.place_age_s > 5)"
        assert browser.run(old) == [True, True, False]
        lines = """return ['1', '2'].map((key) =>
          flotilla.source.track(key).columns.error_m.some(Number.isFinite))"""
        assert browser.run(lines) == [False, True]
        hulls = """const { camera, canvas } = flotilla.plan, ctx = canvas.getContext('2d');
          const ratio = canvas.width / camera.width;
          return flotilla.shown.vessels.map((v) => {
            const [x, y] = camera.at(v.x_m, v.y_m).map((at) => Math.round(at * ratio));
            return [...ctx.getImageData(x, y, 1, 1).data].join();
          })"""
        # only the hull of the boat with a new position is filled with its own colour
        one, two, three = browser.run(hulls)
        assert one == two != three
