# SPDX-License-Identifier: MIT
"""The page: one HTML text that includes its style, its scripts and the plot library.

`page/` contains its parts. Chart.js draws the plots: a wheel has its own copy there, a clone reads
Debian's package.
"""

import json
from collections.abc import Mapping
from functools import cache
from html import escape
from pathlib import Path
from string import Template
from typing import Any

import flotilla

from sil.common.colours import COLOURS
from sil.lockstep import metrics
from sil.view.plain_json import json_of

_PARTS = Path(__file__).parent / "page"
_OWN_LIBRARY = _PARTS / "chart.min.js"
_DEBIANS_LIBRARY = Path("/usr/share/javascript/chart.js/chart.min.js")
LIBRARY = _OWN_LIBRARY if _OWN_LIBRARY.exists() else _DEBIANS_LIBRARY
# in this order: a script uses definitions of those before it
_SCRIPTS = (
    "numbers",
    "colours",
    "track",
    "source_live",
    "source_replay",
    "camera",
    "sea",
    "ground",
    "chart",
    "ruler",
    "boats",
    "planned",
    "thrust_bars",
    "plan",
    "plots",
    "health",
    "cards",
    "events",
    "supervisor",
    "what_if",
    "replay",
    "keys",
    "main",
)
_REQUESTS = (
    "arm",
    "disarm",
    "HOLD",
    "MANUAL",
    "FORMATION",
    "AUTO",
    "GUIDED",
    "LOITER",
    "RTL",
    "test",
    "terminate",
    "nothing",
)


class PageError(RuntimeError):
    """The page cannot be made; the text names what is missing."""


def live(*, has_chart: bool = False) -> str:
    """The live page; it shows the frames, one JSON message each, of the WebSocket `live`.

    `has_chart`: the page loads a chart from the URL `chart`.
    """
    return _page("Flotilla", None, has_chart)


def page_with(history: Mapping[str, Any], title: str, *, has_chart: bool = False) -> str:
    """A page that replays a history of `sil.view.history`.

    It needs no other file, except, if it `has_chart`, that from the URL `chart`.
    """
    return _page(title, history, has_chart)


def frame_with(history: Mapping[str, Any], title: str) -> str:
    """The same page as an iframe inside another one; a sentence if it cannot be made."""
    try:
        inner = page_with(history, title)
    except PageError as error:
        return f'<p class="note">No replay here: {escape(str(error))}.</p>'
    # escape only what an attribute requires: the page is long
    for sign, name in (("&", "amp"), ('"', "quot"), ("<", "lt")):
        inner = inner.replace(sign, f"&{name};")
    return f'<iframe class="replay" title="{escape(title)}" srcdoc="{inner}"></iframe>'


def supervisor_json() -> str:
    """The firmware's supervisor for the page's what-if panel.

    `table`, `conditions`, `losses` and the operator's `choices` of the module `flotilla`, `states`,
    `requests`, and `drives`: by state, the conditions for the propellers to turn.
    """
    content = {
        "states": list(flotilla.STATES),
        "requests": _REQUESTS,
        "conditions": flotilla.supervisor_conditions(),
        "table": flotilla.supervisor_table(),
        "losses": flotilla.supervisor_losses(),
        "choices": flotilla.supervisor_choices(),
        "drives": drives(),
    }
    return json.dumps(content)


def drives() -> dict[str, list[str]]:
    """By state, the conditions that must be met for the propellers to turn, from the firmware.

    An armed boat that is requested to arm keeps its state, so this request lets us clear each
    condition alone.
    """
    names = [c["name"] for c in flotilla.supervisor_conditions()]
    found = {}
    for state in flotilla.STATES:
        if flotilla.supervise(state, "arm", names)["drives"]:
            found[state] = [
                name
                for name in names
                if not flotilla.supervise(state, "arm", [n for n in names if n != name])["drives"]
            ]
    return found


def _page(title: str, history: Mapping[str, Any] | None, has_chart: bool) -> str:
    config = {
        "has_chart": has_chart,
        "colours": COLOURS,
        "settled_m": metrics.SETTLED_M,
        "supervisor": json.loads(supervisor_json()),
    }
    return _template().substitute(
        title=escape(title),
        mode="live" if history is None else "replay",
        connect="'self'" if history is None or has_chart else "'none'",
        images="'self' data:" if has_chart else "data:",
        style=_part("page.css"),
        config=_json(config),
        history=_json(history),
        library=library(),
        script="\n".join(_part(f"{name}.js") for name in _SCRIPTS),
    )


def _json(value: object) -> str:
    """JSON that no HTML parser mistakes for markup."""
    return json_of(value).replace("<", "\\u003c")


@cache
def library() -> str:
    """The source of Chart.js; PageError, naming Debian's package, if it is not installed."""
    try:
        return LIBRARY.read_text(encoding="utf-8")
    except OSError:
        raise PageError(f"no {LIBRARY}; install it with: apt-get install libjs-chart.js") from None


@cache
def _part(name: str) -> str:
    return (_PARTS / name).read_text(encoding="utf-8")


@cache
def _template() -> Template:
    return Template(_part("page.html"))
