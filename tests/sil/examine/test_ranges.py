# SPDX-License-Identifier: MIT
"""Ranges of the law's numbers in Q16.16, measured in every scenario, against core's statements."""

import io
import subprocess
import sys
from pathlib import Path

import pytest
from rich.console import Console

from sil.examine import ranges
from sil.examine.ranges import FileRange, Most
from sil.lockstep.world import Run, sail
from sil.scenario import scenario

ROOT = Path(__file__).resolve().parents[3]
SHORT = ["duration_s=5.0", "scalar='q16'"]
# Two boats' worth of it: the same run with the module that notes its values.
SAIL = """
from sil.examine import ranges
library = ranges.observed()
from sil.lockstep.world import sail
from sil.scenario import scenario
(run,) = sail([scenario.load("diamond", {short})], {{}}, digest=True)
print(run.digest, len(ranges.seen(library.q16_take_seen().decode(), "")))
"""


def run(*command: str | Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, cwd=ROOT, check=False, capture_output=True, text=True)


@pytest.fixture(scope="module")
def built() -> None:
    built = run(ROOT / "tools" / "build", "ranges")
    assert built.returncode == 0, built.stdout + built.stderr


def test_the_module_leaves_the_choice_of_flotilla_to_its_caller() -> None:
    only = "import sys; from sil.examine import ranges; sys.exit('flotilla' in sys.modules)"
    assert run(sys.executable, "-c", only).returncode == 0


@pytest.mark.nightly
def test_noting_ranges_does_not_change_the_digest(built: None) -> None:
    (same,) = sail([scenario.load("diamond", SHORT)], {}, digest=True)
    assert isinstance(same, Run)
    noted = run(sys.executable, "-c", SAIL.format(short=SHORT))
    digest, files = noted.stdout.split()
    assert digest == same.digest and int(files) > 10, noted.stderr


@pytest.mark.nightly
def test_in_every_scenario_each_files_numbers_stay_within_its_stated_range(built: None) -> None:
    told = run(sys.executable, "-m", "sil.examine.ranges", "--seconds", "25")
    assert told.returncode == 0, told.stdout + told.stderr
    unseen = {line.split()[0] for line in told.stdout.splitlines() if line.rstrip().endswith("–")}
    # no scenario has an operator at the sticks, setpoints or a fence; a carried product has 64 bits
    assert unseen == {"manual", "drive", "fence", "carry"}


@pytest.mark.parametrize(
    ("stated", "magnitude", "kept"),
    [
        (100.0, 100.0, True),
        (100.0, 100.1, False),
        (8192.0, 1.0, True),
        (8193.0, 1.0, False),  # four times as much is out of range
        (100.0, None, True),
        (None, 1.0, False),
    ],
)
def test_a_file_keeps_its_range_up_to_the_stated_magnitude(
    stated: float | None, magnitude: float | None, kept: bool
) -> None:
    most = None if magnitude is None else Most(magnitude, 7, "diamond")
    assert FileRange("slot.hpp", stated, most).kept == kept


def test_greatest_of_all_lines_and_runs_is_kept_and_other_folders_are_passed_over() -> None:
    text = (
        "seen/core/core/slot.hpp:7 65536\nseen/core/core/slot.hpp:9 131072\nseen/app/a.hpp:1 9\n"
        "seen/core/core/estimation/track.hpp:3 65536\n"
    )
    first, second = ranges.seen(text, "one"), ranges.seen("x/core/core/slot.hpp:8 98304\n", "two")
    expected = {"slot.hpp": Most(2.0, 9, "one"), "track.hpp": Most(1.0, 3, "one")}
    assert ranges.merged(first, second) == ranges.merged(second, first) == expected


def test_every_file_that_states_a_range_is_read_with_its_thousands(tmp_path: Path) -> None:
    (tmp_path / "a.hpp").write_text("// x\n//\n// Q16.16: tested within ±2,000 (m)\n")
    (tmp_path / "b.hpp").write_text("// no such line\n")
    assert ranges.stated(tmp_path) == {"a.hpp": 2000.0}


def test_terminal_of_80_columns_shows_the_table_whole() -> None:
    console = Console(width=80, file=io.StringIO(), record=True)
    most = {
        "virtual_velocity.hpp": Most(1234.56, 120, "leader_follow_target, product"),
        "carry.hpp": Most(0.16, 61, "tree, paper"),
    }
    console.print(ranges.for_terminal(ranges.rows({"manual.hpp": 5000.0}, most)))
    rows = [line.split() for line in console.export_text().splitlines()[3:6]]
    assert rows == [
        ["carry:61", "0.2", "none", "204,800", "tree,", "paper"],
        ["manual", "–", "5,000", "–", "–"],
        ["virtual_velocity:120", "1,234.6", "none", "27", "leader_follow_target,", "product"],
    ]
