# SPDX-License-Identifier: MIT
"""One browser for all tests of the page; none may cause console errors or outside requests."""

from collections.abc import Iterator

import pytest

from tests.sil.view import browser as driven
from tests.sil.view.browser import Browser
from tests.sil.view.feeder import Feeder, feeding, fleet


@pytest.fixture(scope="session")
def _chromium(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Browser]:
    if not (driven.CHROMIUM and driven.DRIVER):
        pytest.skip(driven.MISSING)
    with driven.chromium(tmp_path_factory.mktemp("chromium")) as browser:
        yield browser


@pytest.fixture
def browser(_chromium: Browser) -> Iterator[Browser]:
    """At 1200 × 800, light. Afterwards asserts no console error and no outside request."""
    _chromium.forget()
    _chromium.size(1200, 800)
    yield _chromium
    _chromium.open("about:blank")  # otherwise the old page would go on drawing
    assert _chromium.errors() == []
    assert _chromium.asked_outside() == []


@pytest.fixture
def four(browser: Browser) -> Iterator[Feeder]:
    """Four boats behind a virtual leader, on their way for 20 s."""
    with feeding(fleet(4), begin_s=20.0) as feeder:
        yield feeder
        browser.open("about:blank")  # otherwise the old page would look for its server
