# SPDX-License-Identifier: MIT
"""python -m tests.sil.view.picture: the picture of the page, sil/results/view.png.

`diamond` sails in lockstep, a view hears it, and Chromium shows its frames. The file tells of what
it was made, for tests/sil/view/test_picture.py.
"""

import hashlib
import io
import json
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from PIL import Image, PngImagePlugin

from sil.plant.hull import Array
from sil.results import published
from sil.view import page
from tests.sil.view.browser import chromium
from tests.sil.view.feed import Listening, sail_and_look
from tests.sil.view.feeder import feeding
from tests.sil.view.live_page import LIVE

PATH = published.PICTURES / "view.png"
MADE_OF = "made of"
SAILED_S = 22.0
SIZE = (1200, 900)
_WINDOW = """const choice = document.getElementById('window'); choice.value = '30';
  choice.dispatchEvent(new Event('change'))"""
_DRAWN_S = 2.0  # plots are redrawn less often than boats

Frames = list[dict[str, Any]]


def frames() -> Frames:
    """The frames, ten per second, of a view that listens from the release on."""
    view, found = Listening(), []

    def look(k: int, said: list[bytes], _: Array) -> None:
        now_s = k / 100
        for data in said:
            view.hear(data, now_s)
        if k % 10 == 0:
            vessels = view.fleet.vessels(now_s)
            heard = {
                "address": "mcast:",
                "bytes_per_s": round(view.ear.heard / max(now_s, 0.1)),
                "damaged": view.ear.damaged,
                "ignored": view.fleet.ignored,
                "vessels": len(vessels),
            }
            found.append({"t_s": now_s, "heard": heard, "vessels": vessels})

    sail_and_look(look, f"duration_s={SAILED_S}")
    return found


def digest(picture: Image.Image, shown: Frames) -> str:
    """SHA-256 of the pixels, the page without its library, and the frames to a millimetre."""
    own = page.live().replace(page.library(), "")
    parts = picture.convert("RGB").tobytes(), own.encode(), json.dumps(_rounded(shown)).encode()
    return hashlib.sha256(b"".join(parts)).hexdigest()


def _rounded(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _rounded(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_rounded(item) for item in value]
    return round(value, 3) if isinstance(value, float) else value


def main() -> int:
    """Exit status: 0."""
    shown = frames()
    texts = iter([json.dumps(frame) for frame in shown])
    last = json.dumps(shown[-1])
    with (
        tempfile.TemporaryDirectory() as folder,
        chromium(Path(folder)) as browser,
        feeding(lambda _: json.dumps(shown[0])) as feeder,
    ):
        browser.size(*SIZE)
        browser.open(feeder.url)
        browser.until(LIVE)
        feeder.frames = lambda _: next(texts, last)
        browser.until("return flotilla.shown.t_s >= arguments[0]", shown[-1]["t_s"])
        browser.run(_WINDOW)
        time.sleep(_DRAWN_S)
        browser.picture(Path(folder) / "page.png")
        with Image.open(Path(folder) / "page.png") as whole:
            picture = whole.convert("RGB").quantize(256, dither=Image.Dither.NONE)
    about = PngImagePlugin.PngInfo()
    about.add_text(MADE_OF, digest(picture, shown))
    content = io.BytesIO()
    picture.save(content, format="png", optimize=True, pnginfo=about)
    PATH.write_bytes(content.getvalue())
    print(f"written: {PATH}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
