# SPDX-License-Identifier: MIT
"""The measurements of a view's cost print figures."""

import pytest

from sil.bench.page_cost import fleet_of, main, said_by
from sil.wire.mavlink_ear import Ear
from tests.sil.view import page_cost
from tests.sil.view.browser import CHROMIUM, DRIVER, MISSING


def test_boats_in_a_line_say_their_state_ten_times_a_second() -> None:
    said = said_by(fleet_of(3))
    heard = [message for _, data in said for message in Ear(stream=False).hear(data)]
    states = [m for m in heard if m.number == 32 and m.system == 2]
    assert 9.5 * said[-1][0] < len(states) < 10.5 * said[-1][0] + 2


def test_the_cost_of_a_fleet_to_the_view_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--boats", "2", "--seconds", "1"]) == 0
    words = capsys.readouterr().out
    assert "2 boats and their leader send" in words and "% of a core" in words


@pytest.mark.nightly
@pytest.mark.skipif(not (CHROMIUM and DRIVER), reason=MISSING)
def test_the_cost_of_the_page_to_a_browser_is_reported(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(page_cost, "_WARM_UP_S", 2.0)
    assert page_cost.main(["--boats", "2", "--seconds", "2"]) == 0
    words = capsys.readouterr().out
    assert "frames a second of 2 boats" in words and "renderer" in words
