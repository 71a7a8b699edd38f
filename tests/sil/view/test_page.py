# SPDX-License-Identifier: MIT
"""The page as text: complete, small, with the firmware's own table."""

import json
import re
from pathlib import Path

import flotilla
import pytest

from sil.view import history, page
from sil.view.history import Boat

NOTHING = {"title": "nothing", "t_s": history.column([]), "vessels": []}


def told(text: str) -> dict[str, object]:
    vessel = history.vessel(Boat(1), "boat", {"x_m": [0.0, 1.0], "y_m": [0.0, 1.0]})
    vessel["texts"] = [[0.0, text]]
    return {"title": text, "t_s": history.column([0.0, 1.0]), "vessels": [vessel]}


def test_live_page_is_small_and_needs_no_other_file() -> None:
    text = page.live()
    assert len(text.encode()) < 1_000_000
    assert not re.search(r'<(script|img|iframe)[^>]* src=|<link[^>]* href="(?!data:)|@import', text)
    assert "default-src 'none'" in text and "connect-src 'self'" in text


def test_replay_page_may_ask_for_nothing_at_all() -> None:
    assert "connect-src 'none'" in page.page_with(NOTHING, "nothing")


def test_texts_of_a_boat_are_never_markup() -> None:
    text = page.page_with(told("</script><script>alert(1)</script>"), "<b>a & b</b>")
    assert text.count("</script>") == page.page_with(NOTHING, "nothing").count("</script>")
    assert "<title>&lt;b&gt;a &amp; b&lt;/b&gt;</title>" in text
    (found,) = re.findall(r'id="history">(.*?)</script>', text)
    assert json.loads(found) == told("</script><script>alert(1)</script>")


def test_frame_is_one_attribute_of_the_report() -> None:
    text = page.frame_with(told('"</iframe>" & more'), "a run")
    assert text.count('"') == 6 and text.count("<") == 2 and text.endswith("</iframe>")


def test_page_without_the_plot_library_names_the_package(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    page.library.cache_clear()
    monkeypatch.setattr(page, "LIBRARY", tmp_path / "chart.min.js")
    with pytest.raises(page.PageError, match=r"apt-get install libjs-chart\.js"):
        page.live()
    assert "libjs-chart.js" in page.frame_with(NOTHING, "nothing")
    monkeypatch.undo()
    page.library.cache_clear()
    assert "Chart.js" in page.library()


def test_supervisor_is_the_firmwares() -> None:
    content = json.loads(page.supervisor_json())
    assert content["table"] == flotilla.supervisor_table()
    assert content["conditions"] == flotilla.supervisor_conditions()
    assert set(content["requests"]) == {row["request"] for row in flotilla.supervisor_table()}
    assert set(content["drives"]) == {
        *("MANUAL", "FORMATION", "COAST", "TEST"),
        *("AUTO", "GUIDED", "LOITER", "RTL"),
    }
    assert content["losses"] == flotilla.supervisor_losses()


def test_choices_are_the_firmwares() -> None:
    choices = json.loads(page.supervisor_json())["choices"]
    assert choices == flotilla.supervisor_choices()
    names = {choice["name"] for choice in choices}
    assert {loss["choice"] for loss in flotilla.supervisor_losses()} <= names
    by_name = {p["name"]: p for p in flotilla.parameter_list()}
    for choice in choices:
        p = by_name[choice["name"]]
        assert len(choice["reactions"]) == p["greatest"] + 1 and choice["default"] == p["default"]
