# SPDX-License-Identifier: MIT
"""A command whose output nobody reads, or whose stream lacks characters, still ends well."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = "import sys; from sil.cli.main import main; sys.exit(main())"
RUN = ("run", "turning", "--set", "duration_s=1", "--out")
FILES = {"recording.bin", "report.html", "summary.json", "trace.npz"}


def flotilla(*arguments: str, read: bool = True, **environment: str) -> tuple[int, str, str]:
    """Status, standard output and standard error; a pipe without a reader unless `read`."""
    with subprocess.Popen(
        [sys.executable, "-c", PROGRAM, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        env={**os.environ, **environment},
    ) as process:
        if not read:
            process.stdout.close()
            process.stdout = None
        out, error = process.communicate()
    return process.returncode, (out or b"").decode(errors="replace"), error.decode()


@pytest.mark.parametrize("arguments", [["--help"], ["scenarios"], ["run", "--help"], ["hulls"]])
def test_a_reader_that_has_left_is_no_error(arguments: list[str]) -> None:
    assert flotilla(*arguments, read=False) == (0, "", "")


def test_a_run_whose_output_nobody_reads_completes_its_files(tmp_path: Path) -> None:
    assert flotilla(*RUN, str(tmp_path), read=False) == (0, "", "")
    assert {path.name for path in tmp_path.iterdir()} >= FILES


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252"])
def test_characters_that_the_encoding_lacks_are_replaced(encoding: str, tmp_path: Path) -> None:
    for arguments in (["--help"], ["scenarios"], [*RUN, str(tmp_path)]):
        status, out, error = flotilla(*arguments, PYTHONIOENCODING=encoding)
        assert (status, error) == (0, "") and out


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no /dev/full")
def test_output_that_a_full_disk_does_not_hold_is_told_at_the_end(tmp_path: Path) -> None:
    for arguments in (["hulls", "otter"], [*RUN, str(tmp_path)]):
        with open("/dev/full", "w") as full:
            done = subprocess.run(
                [sys.executable, "-c", PROGRAM, *arguments],
                stdout=full,
                stderr=subprocess.PIPE,
                text=True,
                check=False,
            )
        assert done.stderr == "error: standard output: No space left on device\n"
        assert done.returncode == 2
    assert {path.name for path in tmp_path.iterdir()} >= FILES
