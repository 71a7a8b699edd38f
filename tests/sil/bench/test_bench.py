# SPDX-License-Identifier: MIT
"""The published instructions per tick; times depend on the machine and are not tested."""

import shutil
import subprocess

import pytest

from sil import ROOT
from sil.bench import bench
from tests import measurements

SHARE = 0.05  # tolerance for another compiler


@pytest.mark.skipif(
    shutil.which("valgrind") is None, reason="no valgrind: apt-get install valgrind"
)
def test_tick_takes_as_many_instructions_as_the_page_says() -> None:
    build = [str(ROOT / "tools" / "build"), "release", bench.PROGRAM.name]
    subprocess.run(build, check=True, capture_output=True)
    now = bench.instructions(["tick"], 1000)
    _, noted = measurements.numbers(measurements.row("tick with own")[0])
    assert now == pytest.approx(noted, rel=SHARE), (
        f"{noted:g} in sil/docs/MEASUREMENTS.md, {now} now: tools/bench"
    )
