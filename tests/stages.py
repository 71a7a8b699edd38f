# SPDX-License-Identifier: MIT
"""Runs every check as a graph of stages, in parallel where they are independent.

Each stage writes out/test/STAGE.log, which is printed if the stage fails. Exit status 1 if a stage
fails, runs no test, or, with --no-skip or CI=true, skips a test. A test in real time that fails is
repeated alone once; if it passes then, it is listed as not judged, with the first failure.
"""

import argparse
import concurrent.futures
import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import BinaryIO
from xml.etree import ElementTree

ROOT = Path(__file__).parents[1]
OUT = ROOT / "out" / "test"
TESTS_FAILED = 1  # exit status of pytest
IMPOSSIBLE = 77  # exit status of tools/with-vcan if vcan is unavailable
NOT_JUDGED = "not judged: "
SLOWEST = 25
PROGRESS_S = 60
#: Targets of the release build that tests run.
RELEASE = "flotillad flotilla_bench socketcan_tests"
#: Tests that need packages and the image, or programs with sanitizers.
OF_IMAGES = ("tests/package", "tests/cortex_m")
OF_SANITIZERS = ("tests/link/mavlink/test_oracle.py", "tests/linux/logs/test_logs.py")
OF_BUILDS = (*OF_IMAGES, *OF_SANITIZERS)


#: Tests that sail boats in real time, or wait for what others send.
LIVE = (
    "tests/clients",
    "tests/linux",
    "tests/loop/test_live.py",
    "tests/sil/doctor",
    "tests/sil/live",
    "tests/sil/view/test_live_fleet.py",
    "tests/sil/view/test_page_served.py",
    "tests/sil/view/test_sailing_fleet.py",
)


@dataclass(frozen=True)
class Stage:
    """`commands` run in sequence after the stages `after`; `tests`: whether they run tests.

    Of the stages with the same `kind` ("": none) one runs at a time. "live": in real time; the
    others have a lower priority (`nice`), because tests/punctual.py does not judge boats on a
    machine that is too slow for them. "build": compiles on all processors for minutes. `again`
    repeats the tests that failed in the last command.
    """

    name: str
    commands: tuple[str, ...]
    after: tuple[str, ...] = ()
    tests: bool = False
    kind: str = ""
    nice: int = 10
    again: str = ""


@dataclass
class Result:
    """The result of a stage; `why`: the reason of a failure, empty if it passed.

    `repeated`: tests failed, and each passed when it was repeated.
    """

    stage: Stage
    wall_s: float = 0
    cpu_s: float = 0
    why: str = ""
    passed: int = 0
    failed: int = 0
    skipped: list[str] = field(default_factory=list)
    not_judged: list[str] = field(default_factory=list)
    repeated: bool = False


def stages(options: argparse.Namespace) -> list[Stage]:
    """Every stage, in an order that respects `after`."""
    out = shlex.quote(str(OUT))
    junit = f"--junitxml={out}/{{}}.xml"
    pytest = ".venv/bin/pytest -rs -o junit_family=xunit1"
    failed = "--last-failed --last-failed-no-failures none"
    in_time = f"{pytest} -o cache_dir={out}/{{}}.failed"
    workers = "--numprocesses {} --dist loadfile --no-loadscope-reorder"
    every = " --all" if options.all else ""
    fuzz_s = 300 if options.all else 2
    words = shlex.join(options.pytest)
    packages = "amd64 arm64 armhf" if options.all else "amd64"
    not_live = " ".join(f"--ignore={path}" for path in (*OF_BUILDS, *LIVE, "tests/vcan"))
    live = " ".join([*LIVE, *(f"--ignore={path}" for path in OF_BUILDS)])
    one_source = "build/dev/tests/CMakeFiles/flotilla_tidied.dir/Unity/*.cxx"
    tidied = (
        "run-clang-tidy-19 -quiet -j 2 -p build/dev 'firmware/.*cpp'"
        if options.all
        else f"clang-tidy-19 -quiet -p build/dev {one_source}"
    )
    found = [
        # Collecting writes the tests' bytecode once; else each worker would, 17 s of each.
        Stage("lint", (f"{pytest} --collect-only -qq tests",
                       "files=$(git ls-files '*.hpp' '*.cpp') && [[ $files ]] && "
                       "clang-format --dry-run --Werror $files",
                       "ruff format --check .", "ruff check .", "mypy"), nice=0),
        Stage("release", (f"tools/build release {RELEASE}",)),
        Stage("vcan", ("tools/with-vcan build/release/tests/socketcan_tests",
                       f"tools/with-vcan {in_time.format('vcan')} {junit.format('vcan')}{every}"
                       " tests/vcan"),
              ("release",), tests=True, kind="live", nice=0,
              again=f"tools/with-vcan {in_time.format('vcan')} {failed}{every} tests/vcan"),
        Stage("live", (f"{in_time.format('live')} {junit.format('live')} {live}{every}"
                       f" {workers.format(4)} {words if options.only == 'live' else ''}",),
              ("release",), tests=True, kind="live", nice=0,
              again=f"{in_time.format('live')} {failed} {live}{every}"),
        Stage("python", (f"{pytest} {junit.format('python')} {not_live} {workers.format(3)}{every}"
                         f" {words}",),
              ("release",), tests=True),
        # Before the sanitizers, whose tests can then use both processors to the end.
        Stage("packages", ("tools/build cortex-m", f"tools/package {packages}"), ("release",),
              kind="build"),
        Stage("images", (f"{pytest} {junit.format('images')}{every} {' '.join(OF_IMAGES)}",),
              ("packages",), tests=True),
        Stage("sanitizers", ("tools/build dev",), ("release",), kind="build"),
        Stage("firmware", ("ctest --preset dev --parallel 2 --no-tests=error "
                           f"--output-junit {out}/firmware.xml",), ("sanitizers",), tests=True),
        Stage("oracles", (f"{pytest} {junit.format('oracles')}{every} {' '.join(OF_SANITIZERS)}",),
              ("sanitizers",), tests=True),
        Stage("fuzz", (f"tools/fuzz --seconds {fuzz_s} --no-merge",), ("sanitizers",), tests=True),
        Stage("tidy", (tidied,), ("sanitizers",)),
    ]  # fmt: skip
    if options.all:
        found += [
            Stage("ranges", ("tools/fixed --ranges",), ("images",), kind="build"),
            Stage("fixed", ("tools/fixed",), ("python", "images")),
        ]
    if not options.only:
        return found
    needed = {options.only}
    for stage in reversed(found):
        if stage.name in needed:
            needed |= set(stage.after)
    return [stage for stage in found if stage.name in needed]


def run(stage: Stage) -> Result:
    """Run a stage's commands until one fails, without standard input."""
    result = Result(stage)
    begin = time.monotonic()
    log = OUT / f"{stage.name}.log"
    with log.open("wb") as file:
        for command in stage.commands:
            status = execute(command, result, file)
            if status == IMPOSSIBLE and stage.name == "vcan":
                result.skipped.append(f"tests on the kernel's CAN: {last_line(log)}")
                break
            result.repeated = (
                status == TESTS_FAILED
                and command == stage.commands[-1]
                and bool(stage.again and not execute(stage.again, result, file))
            )
            if status and not result.repeated:
                result.why = f"`{command}` ended with status {status}"
                break
    result.wall_s = time.monotonic() - begin
    count(result, log)
    if stage.tests and not (result.why or result.skipped or result.passed):
        result.why = "no test was run"
    return result


def execute(command: str, result: Result, log: BinaryIO) -> int:
    """Run a command of a stage and add its CPU time; its exit status."""
    log.write(f"$ {command}\n".encode())
    log.flush()
    process = subprocess.Popen(
        ["nice", f"-n{result.stage.nice}", "bash", "-c", command],
        cwd=ROOT,
        stdin=subprocess.DEVNULL,
        stdout=log,
        stderr=log,
    )
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    result.cpu_s += usage.ru_utime + usage.ru_stime
    return process.returncode


def last_line(log: Path) -> str:
    """The last line of a stage's log."""
    return log.read_text(errors="replace").strip().splitlines()[-1]


def count(result: Result, log: Path) -> None:
    """Count the tests of pytest and ctest in their reports, of doctest and fuzzer in the log."""
    for case in test_cases(result.stage.name):
        skipped = case.find("skipped")
        where = f"{case.get('file') or case.get('classname')}::{case.get('name')}"
        failure = next((fault for fault in case if fault.tag in {"failure", "error"}), None)
        if failure is not None and result.repeated:
            first = (failure.get("message") or "for no reason").splitlines()[0]
            result.not_judged.append(f"{where}: passed when repeated; failed with: {first}")
        elif failure is not None:
            result.failed += 1
        elif skipped is None:
            result.passed += 1
        else:
            reason = skipped.get("message") or "for no reason"
            if reason.startswith(NOT_JUDGED):
                result.not_judged.append(f"{where}: {reason.removeprefix(NOT_JUDGED)}")
            else:
                result.skipped.append(f"{where}: {reason}")
    text = log.read_text(errors="replace")
    doctest = r"^\[doctest\] test cases: .*?(\d+) passed .*?(\d+) failed"
    for passed, failed in re.findall(doctest, text, re.MULTILINE):
        result.passed += int(passed)
        result.failed += int(failed)
    result.passed += sum(map(int, re.findall(r"replayed (\d+) kept inputs", text)))


def test_cases(name: str) -> list[ElementTree.Element]:
    """The test cases in the stage's report; none without a report."""
    report = OUT / f"{name}.xml"
    return list(ElementTree.parse(report).iter("testcase")) if report.exists() else []


def run_all(todo: list[Stage], told: Callable[[Result], None]) -> list[Result]:
    """Run each stage as soon as the stages it needs have passed."""
    results: dict[str, Result] = {}
    with concurrent.futures.ThreadPoolExecutor(len(todo)) as pool:
        running: dict[concurrent.futures.Future[Result], Stage] = {}
        waiting = list(todo)
        while waiting or running:
            for stage in list(waiting):
                if any(name in results and results[name].why for name in stage.after):
                    waiting.remove(stage)
                    results[stage.name] = Result(stage, why=f"needs {' and '.join(stage.after)}")
                    told(results[stage.name])
                elif all(name in results for name in stage.after) and not (
                    stage.kind and stage.kind in {other.kind for other in running.values()}
                ):
                    waiting.remove(stage)
                    running[pool.submit(run, stage)] = stage
            done, _ = concurrent.futures.wait(running, PROGRESS_S, "FIRST_COMPLETED")
            if not done:
                print(f"{'…':12}{', '.join(stage.name for stage in running.values())}", flush=True)
            for future in done:
                results[running.pop(future).name] = future.result()
                told(future.result())
    return [results[stage.name] for stage in todo]


def tell(result: Result) -> None:
    """Print a line for a finished stage, and its log if it failed."""
    verdict = "FAILED" if result.why else "passed"
    print(f"{result.stage.name:12}{verdict}  {clock(result.wall_s)}", flush=True)
    log = OUT / f"{result.stage.name}.log"
    if result.why and log.exists():
        print(f"\n{log.read_text(errors='replace')}\n", flush=True)


def clock(seconds: float) -> str:
    """Format as minutes and seconds."""
    return f"{int(seconds) // 60:3}:{int(seconds) % 60:02}"


def print_slowest(todo: list[Stage]) -> None:
    """Print the slowest tests of all stages."""
    cases = [(float(case.get("time") or 0), case) for s in todo for case in test_cases(s.name)]
    cases.sort(key=lambda one: -one[0])
    print(f"\nslowest {SLOWEST} tests")
    for seconds, case in cases[:SLOWEST]:
        print(f"{seconds:7.1f} s  {case.get('classname')}::{case.get('name')}")


def verdict(results: list[Result], *, no_skip: bool) -> int:
    """Print times, skipped tests and sums; the exit status."""
    print(f"\n{'stage':12}{'wall':>7}{'CPU':>8}{'passed':>8}{'failed':>8}{'skipped':>9}")
    for r in results:
        numbers = f"{r.passed:8}{r.failed:8}{len(r.skipped):9}" if r.stage.tests else ""
        print(f"{r.stage.name:12}{clock(r.wall_s):>7}{clock(r.cpu_s):>8}{numbers}")
    for r in results:
        for line in r.not_judged:
            print(f"NOT JUDGED: {line}")
        for line in r.skipped:
            print(f"{'FAILED, SKIPPED' if no_skip else 'NOT TESTED'}: {line}")
        if r.why:
            print(
                f"FAILED: {r.stage.name}: {r.why}; see {OUT.relative_to(ROOT)}/{r.stage.name}.log"
            )
    skipped = sum(len(r.skipped) for r in results)
    failed = sum(r.failed or bool(r.why) for r in results) + (skipped if no_skip else 0)
    passed = sum(r.passed for r in results)
    unjudged = sum(len(r.not_judged) for r in results)
    print(
        f"tests: {passed} passed, {failed} failed, {unjudged + (0 if no_skip else skipped)} skipped"
    )
    return 1 if failed else 0


def arguments(words: list[str]) -> argparse.Namespace:
    """Parse the arguments of tools/test."""
    parser = argparse.ArgumentParser(prog="tools/test", description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--all", action="store_true", help="the nightly tests too; without, half an hour")
    add("--no-skip", action="store_true", help="a skipped test fails the run; so with CI=true")
    add("--only", metavar="STAGE", help="this stage and those that it needs")
    add("--coverage", action="store_true", help="instead, the share of lines that C++ tests reach")
    add("pytest", nargs="*", metavar="ARG", help="for pytest, after --")
    options = parser.parse_args(words)
    options.no_skip |= os.environ.get("CI") == "true"
    names = [stage.name for stage in stages(argparse.Namespace(**vars(options) | {"only": None}))]
    if options.only and options.only not in names:
        parser.error(f"unknown stage {options.only}; choose from {', '.join(names)}")
    return options


def main() -> int:
    """Run all stages and print the verdict."""
    options = arguments(sys.argv[1:])
    todo = stages(options)
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir(parents=True)
    if options.no_skip and any(stage.name == "vcan" for stage in todo):
        probe = subprocess.run(["tools/with-vcan", "true"], cwd=ROOT, check=False)
        if probe.returncode:
            print("FAILED: no vcan, the reason is above\ntests: 0 passed, 1 failed")
            return 1
    print(f"{'stage':12}logs in {OUT.relative_to(ROOT)}/", flush=True)
    try:
        results = run_all(todo, tell)
    except KeyboardInterrupt:
        return 130
    print_slowest(todo)
    return verdict(results, no_skip=options.no_skip)


if __name__ == "__main__":
    sys.exit(main())
