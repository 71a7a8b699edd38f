# SPDX-License-Identifier: MIT
"""The instructions of a tick that the README tells of; times are the machine's, and not held."""

import shutil
import subprocess

import pytest

from sil.bench import bench
from tests import readme

SHARE = 0.05  # of another compiler's code


@pytest.mark.skipif(
    shutil.which("valgrind") is None, reason="no valgrind: apt-get install valgrind"
)
def test_tick_takes_as_many_instructions_as_the_readme_says() -> None:
    build = [bench.ROOT / "tools" / "build", "release", bench.PROGRAM.name]
    subprocess.run(build, check=True, capture_output=True)
    now = bench.instructions(["tick"], 1000)
    _, noted = readme.numbers(readme.row("tick with own")[0])
    assert now == pytest.approx(noted, rel=SHARE), (
        f"{noted:g} in the README, {now} now: tools/bench"
    )
