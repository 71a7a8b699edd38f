# SPDX-License-Identifier: MIT
"""Runs the fuzz targets: tools/fuzz [TARGET …] [--seconds N] [--jobs N] [--no-merge] [--coverage].

Each begins with its kept corpus (tests/fuzz/corpus/TARGET.tar.xz) and its seeds. What it finds is
merged into the corpus, as few and as short inputs as reach the same. Inputs that crash are kept in
out/fuzz. Exit status 1 where there is one.
"""

import argparse
import concurrent.futures
import hashlib
import io
import os
import re
import shutil
import subprocess
import sys
import tarfile
import time
from dataclasses import dataclass
from pathlib import Path

from tests import coverage
from tests.fuzz import seeds

ROOT = Path(__file__).parents[2]
CORPUS = Path(__file__).parent / "corpus"
OUT = ROOT / "out" / "fuzz"
PROGRAMS = ROOT / "build" / "dev" / "tests" / "fuzz"
TARGETS = ("mavlink", "can", "parameters", "history", "missions")
# A history of this length covers some seconds of a boat's life; longer ones only cost time.
LONGEST = {"history": 1024, "mavlink": 2048, "can": 2048, "parameters": 4096, "missions": 1024}
CALL_LIMIT_S = 20
PROGRESS_S = 10


@dataclass
class Result:
    """The result of one target's run."""

    target: str
    executions: int
    per_s: int
    corpus: int
    crashes: list[Path]

    def row(self) -> str:
        """One line of the table."""
        return (
            f"{self.target:12} {self.executions:12,} {self.per_s:8,} {self.corpus:8,}"
            f" {len(self.crashes):8}"
        )


def unpack(target: str, folder: Path) -> int:
    """Unpack the kept inputs into an empty folder; their number."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    kept = CORPUS / f"{target}.tar.xz"
    if kept.exists():
        with tarfile.open(kept) as archive:
            for member in archive.getmembers():
                content = archive.extractfile(member)
                assert content is not None
                (folder / member.name).write_bytes(content.read())
    return len(list(folder.iterdir()))


def pack(target: str, folder: Path) -> int:
    """Pack the inputs; equal inputs give equal bytes."""
    contents = {hashlib.sha1(p.read_bytes()).hexdigest(): p.read_bytes() for p in folder.iterdir()}
    CORPUS.mkdir(exist_ok=True)
    with tarfile.open(CORPUS / f"{target}.tar.xz", "w:xz", preset=9) as archive:
        for name in sorted(contents, key=lambda n: (len(contents[n]), n)):
            member = tarfile.TarInfo(name)
            member.size = len(contents[name])
            archive.addfile(member, io.BytesIO(contents[name]))
    return len(contents)


def command(target: str) -> list[str | Path]:
    """The command line common to all runs of a target."""
    return [PROGRAMS / f"fuzz_{target}", f"-timeout={CALL_LIMIT_S}", "-rss_limit_mb=1024"]


def executions(log: Path) -> int:
    """The number of executions by libFuzzer's log."""
    numbers = re.findall(r"^#(\d+)\t", log.read_text(errors="replace"), re.MULTILINE)
    return max((int(n) for n in numbers), default=0)


def fuzz(target: str, seconds: int, keep: bool) -> Result:
    """Fuzz one target; stores crashing inputs in out/fuzz, with the commands to repeat them."""
    work = OUT / target
    shutil.rmtree(work, ignore_errors=True)
    kept, found, crashes = work / "kept", work / "found", work / "crashes"
    unpack(target, kept)
    for folder in (found, crashes):
        folder.mkdir()
    options = [
        f"-max_total_time={seconds}",
        f"-max_len={LONGEST[target]}",
        "-print_final_stats=1",
        "-reload=0",
        f"-artifact_prefix={crashes}/",
    ]
    log = work / "log.txt"
    begin = time.monotonic()
    inputs = [found, kept, OUT / "seeds" / target]
    with (
        log.open("w") as file,
        subprocess.Popen(
            [*command(target), *options, *inputs], stdout=file, stderr=subprocess.STDOUT
        ) as process,
    ):
        while True:
            try:
                process.wait(PROGRESS_S)
                break
            except subprocess.TimeoutExpired:
                past = round(time.monotonic() - begin)
                print(
                    f"{target:12} {past:5} s of {seconds}, {executions(log):,} so far", flush=True
                )
    took_s = max(time.monotonic() - begin, 1)
    count, done = len(list(kept.iterdir())), executions(log)
    # Slow inputs, perhaps due to other load, appear in the log only.
    inputs_that_crash = sorted(p for p in crashes.iterdir() if not p.name.startswith("slow-unit"))
    if done < count and not inputs_that_crash:
        raise RuntimeError(f"{target}: only {done} of {count} kept inputs were replayed, see {log}")
    if process.returncode != 0 and not inputs_that_crash:
        raise RuntimeError(f"{target}: the run failed, see {log}")
    if keep and not inputs_that_crash:
        count = merge(target, work, inputs)
    return Result(target, done, round(done / took_s), count, inputs_that_crash)


def merge(target: str, work: Path, inputs: list[Path]) -> int:
    """Keep the smallest set of inputs with the same coverage; its size."""
    merged = work / "merged"
    merged.mkdir()
    with (work / "merge.txt").open("w") as log:
        subprocess.run(
            [*command(target), "-merge=1", merged, *inputs], stdout=log, stderr=log, check=True
        )
    return pack(target, merged)


def print_coverage(targets: list[str]) -> None:
    """Print the coverage of link and app by the kept corpora."""
    coverage.PROFILES.mkdir(parents=True, exist_ok=True)
    for old in coverage.PROFILES.glob("fuzz-*"):
        old.unlink()
    programs = []
    for target in targets:
        folder = OUT / target / "kept"
        print(f"{target}: {unpack(target, folder)} inputs …", flush=True)
        programs.append(coverage.BUILD / "tests" / "fuzz" / f"fuzz_{target}")
        profile = str(coverage.PROFILES / f"fuzz-{target}.profraw")
        subprocess.run(
            [programs[-1], *sorted(folder.iterdir())],
            check=True,
            env=os.environ | {"LLVM_PROFILE_FILE": profile},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
    files = coverage.read(programs, "fuzz")
    coverage.print_table({n: c for n, c in files.items() if n.startswith(("link/", "app/"))})


def arguments() -> argparse.Namespace:
    """Parse the command line."""
    parser = argparse.ArgumentParser(prog="tools/fuzz", description=__doc__.splitlines()[0])
    parser.add_argument("targets", nargs="*", metavar="TARGET", help=", ".join(TARGETS))
    parser.add_argument("--seconds", type=int, default=60, help="for each target (60)")
    parser.add_argument("--jobs", type=int, default=2, help="targets at a time (2)")
    parser.add_argument("--no-merge", action="store_true", help="leave the kept corpora alone")
    parser.add_argument("--coverage", action="store_true", help="what the kept corpora reach")
    options = parser.parse_args()
    unknown = sorted(set(options.targets) - set(TARGETS))
    if unknown:
        parser.error(f"no target {', '.join(unknown)} (there are: {', '.join(TARGETS)})")
    options.targets = options.targets or list(TARGETS)
    return options


def main() -> int:
    """Exit status 1 if an input crashes."""
    options = arguments()
    if options.coverage:
        print_coverage(options.targets)
        return 0
    seeds.write(OUT / "seeds")
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        runs = [
            pool.submit(fuzz, target, options.seconds, not options.no_merge)
            for target in options.targets
        ]
        results = [run.result() for run in runs]
    print(f"\n{'target':12} {'executions':>12} {'exec/s':>8} {'corpus':>8} {'crashes':>8}")
    for result in results:
        print(result.row())
    print(f"replayed {sum(result.corpus for result in results)} kept inputs")
    crashes = [(r.target, path) for r in results for path in r.crashes]
    for target, path in crashes:
        print(f"CRASH: build/dev/tests/fuzz/fuzz_{target} {path.relative_to(ROOT)}")
    return 1 if crashes else 0


if __name__ == "__main__":
    sys.exit(main())
