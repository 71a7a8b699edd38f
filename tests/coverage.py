# SPDX-License-Identifier: MIT
"""Measures the firmware's lines, branches and MC/DC pairs that C++ tests or fuzz corpora reach.

Reads clang's profiles of programs built by the preset `coverage`; a template counts once, by the
instantiation that is reached best.
"""

import json
import os
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).parents[1]
BUILD = ROOT / "build" / "coverage"
PROFILES = BUILD / "profiles"
LLVM = "19"
TESTS = (
    "core_tests",
    "supervisor_tests",
    "voyages_tests",
    "link_tests",
    "app_tests",
    "linux_tests",
)
SUPERVISOR = "core/supervisor.hpp"
# Least share of lines and of branches.
LIMITS = {"core": (1.0, 1.0), "link": (0.95, 0.90), "app": (0.95, 0.90)}


@dataclass
class Count:
    """Number of items, and how many of them were reached."""

    reached: int = 0
    all: int = 0

    def add(self, summary: dict[str, int]) -> None:
        """One file's, as llvm-cov says it."""
        self.reached += summary["covered"]
        self.all += summary["count"]

    @property
    def share(self) -> float:
        """Share of items that were reached; 1 if there are none."""
        return self.reached / self.all if self.all else 1.0

    def __str__(self) -> str:
        return f"{self.reached:5} of {self.all:5} {100 * self.share:6.1f} %"


@dataclass
class Coverage:
    """Coverage of a file or a room."""

    lines: Count = field(default_factory=Count)
    branches: Count = field(default_factory=Count)
    mcdc: Count = field(default_factory=Count)

    def add(self, summary: dict[str, dict[str, int]]) -> None:
        """One file's, as llvm-cov says it."""
        self.lines.add(summary["lines"])
        self.branches.add(summary["branches"])
        self.mcdc.add(summary["mcdc"])

    def row(self, name: str) -> str:
        """One line of a table."""
        return f"{name:28} {self.lines}   {self.branches}   {self.mcdc}"


def read(programs: Sequence[Path], name: str) -> dict[str, Coverage]:
    """Coverage by file, room/name, from the profiles NAME-*.profraw."""
    merged = PROFILES / f"{name}.profdata"
    raw = sorted(PROFILES.glob(f"{name}-*.profraw"))
    subprocess.run([f"llvm-profdata-{LLVM}", "merge", "-sparse", *raw, "-o", merged], check=True)
    objects = [word for program in programs[1:] for word in ("-object", program)]
    command = [f"llvm-cov-{LLVM}", "export", "-summary-only", "--show-mcdc-summary"]
    out = subprocess.run(
        [*command, f"-instr-profile={merged}", programs[0], *objects],
        check=True,
        stdout=subprocess.PIPE,
    )
    files: dict[str, Coverage] = {}
    for entry in json.loads(out.stdout)["data"][0]["files"]:
        # Headers are found through links in the build tree.
        path = Path(entry["filename"]).resolve()
        if path.is_relative_to(ROOT / "firmware"):
            key = str(path.relative_to(ROOT / "firmware"))
            files.setdefault(key, Coverage()).add(entry["summary"])
    return files


def rooms(files: dict[str, Coverage]) -> dict[str, Coverage]:
    """Coverage by room, for rooms with limits."""
    sums = {room: Coverage() for room in LIMITS}
    for name, file in files.items():
        room = sums.get(name.split("/")[0])
        if room:
            for total, one in ((room.lines, file.lines), (room.branches, file.branches)):
                total.reached += one.reached
                total.all += one.all
            room.mcdc.reached += file.mcdc.reached
            room.mcdc.all += file.mcdc.all
    return sums


def print_table(files: dict[str, Coverage]) -> None:
    """Print files without full coverage, then rooms."""
    print(f"{'':28} {'lines':>23}   {'branches':>23}   {'MC/DC':>23}")
    for name, file in sorted(files.items()):
        whole = file.lines.share == 1 and file.branches.share == 1
        if name.split("/")[0] in LIMITS and (not whole or name == SUPERVISOR):
            print(file.row(name))
    for name, room in rooms(files).items():
        print(room.row(name))


def failures(files: dict[str, Coverage]) -> list[str]:
    """One sentence for each figure below its limit."""
    out = []
    for name, room in rooms(files).items():
        if not (room.lines.all and room.branches.all):
            out.append(f"{name}: nothing was counted")
        for what, count, least in zip(
            ("lines", "branches"), (room.lines, room.branches), LIMITS[name], strict=True
        ):
            if count.share < least:
                out.append(
                    f"{name}: {what} {100 * count.share:.1f} %, at least {100 * least:.0f} %"
                )
    mcdc = files.get(SUPERVISOR, Coverage()).mcdc
    if mcdc.reached < max(1, mcdc.all):
        out.append(f"{SUPERVISOR}: MC/DC is not complete")
    return out


def run_tests() -> list[Path]:
    """Run the C++ tests, which write profiles; the programs."""
    PROFILES.mkdir(parents=True, exist_ok=True)
    for old in PROFILES.glob("tests-*"):
        old.unlink()
    environment = os.environ | {"LLVM_PROFILE_FILE": str(PROFILES / "tests-%p.profraw")}
    programs = [BUILD / "tests" / name for name in TESTS]
    for program in programs:
        print(f"{program.name} …", flush=True)
        subprocess.run([program, "--minimal"], check=True, env=environment, cwd=BUILD / "tests")
    return programs


def main() -> int:
    """Exit status 1 if coverage is below a limit."""
    files = read(run_tests(), "tests")
    print_table(files)
    failed = failures(files)
    for sentence in failed:
        print(f"TOO LITTLE: {sentence}")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
