# SPDX-License-Identifier: MIT
"""Reports in Chromium: their embedded page plays."""

from pathlib import Path

from sil.report import run_report
from sil.report.drawing import draw
from tests.sil.report.test_run_report import COMMAND, made_up_run
from tests.sil.view.browser import Browser

INSIDE = "const inside = frames[0]; return "


def test_report_of_a_run_plays_it(browser: Browser, tmp_path: Path) -> None:
    summary, trace = made_up_run()
    run_report.write(tmp_path, summary, trace, COMMAND, draw("pair", trace))
    browser.open((tmp_path / "report.html").as_uri())
    browser.until(INSIDE + "inside.flotilla?.plots && inside.flotilla.shown !== null")
    assert browser.run(INSIDE + "inside.document.querySelectorAll('.card').length") == 3
    browser.until(INSIDE + "inside.flotilla.shown.t_s > 0.3")  # it begins by itself
    button = "inside.document.getElementById('pause')"
    browser.run(INSIDE + f"{button}.click()")
    assert browser.run(INSIDE + f"{button}.textContent") == "Play"


def test_report_fits_a_phone(browser: Browser, tmp_path: Path) -> None:
    summary, trace = made_up_run()
    run_report.write(tmp_path, summary, trace, COMMAND, draw("pair", trace))
    browser.size(360, 740)
    browser.open((tmp_path / "report.html").as_uri())
    browser.until(INSIDE + "inside.flotilla?.shown && true")
    wide = INSIDE + "[document, inside.document].map((d) => d.documentElement.scrollWidth)"
    outer, inner = browser.run(wide)
    assert outer <= 360 and inner <= browser.run(INSIDE + "inside.innerWidth")
