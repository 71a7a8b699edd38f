# SPDX-License-Identifier: MIT
"""--help of a tool prints its description and does nothing else."""

import shutil
import subprocess
from pathlib import Path

import pytest

TOOLS = Path(__file__).parents[2] / "tools"
NEEDED = ("env", "bash", "sed", "dirname")
NAMES = "bench build certify demo docs faults fixed flakes fuzz metal package reference setup"


@pytest.mark.parametrize("name", NAMES.split())
def test_a_tool_asked_for_help_prints_it_and_starts_nothing(name: str, tmp_path: Path) -> None:
    programs = tmp_path / "bin"
    programs.mkdir()
    for program in NEEDED:
        found = shutil.which(program)
        assert found
        (programs / program).symlink_to(found)
    tool = tmp_path / "tools" / name
    tool.parent.mkdir()
    shutil.copy(TOOLS / name, tool)
    command = [f"../tools/{name}", "--help"]
    environment = {"PATH": str(programs)}
    done = subprocess.run(
        command, cwd=programs, env=environment, capture_output=True, text=True, check=False
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert len(done.stdout.split()) > 8 and "set -e" not in done.stdout
    assert sorted(tmp_path.rglob("*")) == sorted(
        [programs, tool.parent, tool, *(programs / program for program in NEEDED)]
    )
