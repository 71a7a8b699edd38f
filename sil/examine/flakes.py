# SPDX-License-Identifier: MIT
"""Finds flaky tests, and lockstep runs whose digest is not reproducible."""

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import rich.progress
from rich.console import Console

from sil import ROOT
from sil.common import pool
from sil.lockstep.start import RunError
from sil.lockstep.world import sail
from sil.scenario import scenario
from sil.scenario.scenario import FOLDER

_LONGEST_S = 30.0
_NONE = "no digest: "
_FINE = (0, 77)  # 77: skipped because there is no vcan
Task = tuple[str, int]  # scenario, number of the run
# The commands of tools/test, except those whose result depends on the sources alone.
SUITE = (
    ("ctest", "--preset", "dev", "--parallel", "2"),
    ("tools/with-vcan", "build/release/tests/socketcan_tests"),
    ("tools/with-vcan", str(ROOT / ".venv/bin/pytest"), "-rs", "tests/vcan"),
    ("pytest", "-rs", "--ignore=tests/vcan", "--numprocesses", "4", "--dist", "loadfile"),
)


def digest_of(task: Task) -> str:
    """Digest of a scenario's first seconds, or the reason for a failure."""
    chosen = scenario.load(task[0])
    short = chosen.model_copy(update={"duration_s": min(chosen.duration_s, _LONGEST_S)})
    (run,) = sail([short], {}, digest=True)
    return f"{_NONE}{run}" if isinstance(run, RunError) else run.digest or _NONE


def lockstep(runs: int, console: Console, digest: Callable[[Task], str] = digest_of) -> int:
    """Sail every scenario in turn, `runs` in all; return how many runs differ from the first.

    A failed run counts as different, even if it fails every time. Each run is compared with the
    first run of its scenario.
    """
    names = sorted(path.stem for path in FOLDER.glob("*.toml"))
    tasks: list[Task] = [(names[i % len(names)], i) for i in range(runs)]
    first: dict[str, str] = {}
    differing: list[str] = []
    with rich.progress.Progress(console=console) as progress:
        bar = progress.add_task("lockstep runs", total=runs)

        def note(task: Task, found: str) -> None:
            if found.startswith(_NONE):
                differing.append(f"run {task[1]}: {task[0]} has {found}")
            elif first.setdefault(task[0], found) != found:
                differing.append(
                    f"run {task[1]}: {task[0]} {found[:16]}, not {first[task[0]][:16]}"
                )
            progress.advance(bar)

        lost = pool.run(digest, tasks, os.cpu_count() or 1, note)
    differing += [f"run {i}: {name} killed its process" for name, i in lost]
    for line in differing:
        console.print(f"[bold red]{line}")
    console.print(f"lockstep: {len(first)} scenarios, {runs} runs, {len(differing)} differ")
    return len(differing)


def suite(
    rounds: int, log: Path, console: Console, commands: Sequence[Sequence[str]] = SUITE
) -> int:
    """Run all tests `rounds` times; return the number of rounds that failed. Output goes to `log`.

    The commands of a round run in parallel: that is faster, and the load exposes more failures.
    """
    log.parent.mkdir(parents=True, exist_ok=True)
    failed = 0
    with log.open("wb") as file, ThreadPoolExecutor(len(commands)) as threads:
        for number in range(1, rounds + 1):
            began_s = time.monotonic()
            bad = []
            for command, done in zip(commands, threads.map(_run, commands), strict=True):
                file.write(done.stdout)
                file.flush()
                if done.returncode not in _FINE:
                    bad.append(command)
            failed += bool(bad)
            told = "passed" if not bad else "FAILED: " + "; ".join(" ".join(c) for c in bad)
            console.print(
                f"round {number} of {rounds}: {told} ({time.monotonic() - began_s:.0f} s)"
            )
    console.print(f"suite: {rounds} rounds, {failed} failed; output: {log}")
    return failed


def _run(command: Sequence[str]) -> subprocess.CompletedProcess[bytes]:
    # our own tests, by name
    return subprocess.run(  # noqa: S603
        command, check=False, cwd=ROOT, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
    )


def main(arguments: Sequence[str]) -> int:
    """Run the module's command line; exit status 0 if everything was reproducible, else 1."""
    parser = argparse.ArgumentParser(prog="tools/flakes", description=__doc__)
    parser.add_argument(
        "--suite", type=int, default=20, metavar="N", help="number of rounds of all tests (20)"
    )
    parser.add_argument(
        "--lockstep", type=int, default=1000, metavar="N", help="number of runs (1000)"
    )
    options = parser.parse_args(arguments)
    console = Console()
    passed = failed = 0
    if options.lockstep > 0:
        differing = lockstep(options.lockstep, console)
        passed, failed = options.lockstep - differing, differing
    if options.suite > 0:
        bad = suite(options.suite, ROOT / "out" / "flakes.log", console)
        passed, failed = passed + options.suite - bad, failed + bad
    print(f"{passed} passed, {failed} failed")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
