# SPDX-License-Identifier: MIT
"""python -m tests.sil.view.page_cost: measures the cost of the live page in a browser.

Debian's Chromium without a screen or a GPU shows `tools/view` hearing a line of boats, as
`python -m sil.bench.page_cost` has them. Its renderer runs the page; the others put pixels
together, which a GPU does elsewhere, and carry bytes.
"""

import argparse
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import psutil

from sil.bench.page_cost import fleet_of, said_by, viewed
from sil.scenario import arguments
from tests.sil.view.browser import chromium

_WARM_UP_S = 30.0
_FRAMES = "return flotilla.source.frames"


def used_s() -> Counter[str]:
    """Seconds of processor time of this process's browsers so far, by their processes' type."""
    found: Counter[str] = Counter()
    for process in psutil.Process().children(recursive=True):
        words = process.cmdline()
        if words and Path(words[0]).name == "chromium":
            kinds = [word.partition("=")[2] for word in words if word.startswith("--type=")]
            times = process.cpu_times()
            found[kinds[0] if kinds else "browser"] += times.user + times.system
    return found


def main(given: Sequence[str]) -> int:
    """Exit status: 0."""
    parser = argparse.ArgumentParser(prog="python -m tests.sil.view.page_cost", description=__doc__)
    parser.add_argument("--boats", type=arguments.count, default=20, metavar="N", help="(20)")
    parser.add_argument("--seconds", type=float, default=30.0, metavar="S", help="(30)")
    parser.add_argument("--width", type=arguments.count, default=1280, metavar="PX", help="(1280)")
    parser.add_argument("--height", type=arguments.count, default=800, metavar="PX", help="(800)")
    options = parser.parse_args(given)
    said = said_by(fleet_of(options.boats))
    with tempfile.TemporaryDirectory() as folder, chromium(Path(folder), noting=False) as browser:
        browser.size(options.width, options.height)
        with viewed(said) as (url, _):
            browser.open(url)
            time.sleep(_WARM_UP_S)
            began, began_s = used_s(), time.monotonic()
            frames = browser.run(_FRAMES)
            time.sleep(options.seconds)
            frames = browser.run(_FRAMES) - frames
            used, passed_s = used_s() - began, time.monotonic() - began_s
    print(f"{frames / passed_s:.1f} frames a second of {options.boats} boats, % of a core:")
    print(f"{'all':>12} {100.0 * sum(used.values()) / passed_s:5.1f}")
    for kind, busy_s in used.most_common():
        print(f"{kind:>12} {100.0 * busy_s / passed_s:5.1f}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
