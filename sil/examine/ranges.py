# SPDX-License-Identifier: MIT
"""The largest magnitude of the law's numbers in Q16.16, by file, over all scenarios.

Uses a native module whose Q16 records its values (tests/core/observed_q16.hpp). Each file of
firmware/core states its tested range, at most a quarter of the range of Q16.16; no number in any
scenario may exceed it. `tools/fixed --ranges` prints the table.
"""

import argparse
import ctypes
import importlib.util
import re
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from rich import box
from rich.console import Console
from rich.progress import track
from rich.table import Table

from sil import ROOT

CORE = ROOT / "firmware" / "core"
FOLDER = ROOT / "build" / "ranges" / "sil" / "native" / "module"
MARGIN = 4.0
_END = 32768.0
_STATED = re.compile(r"^// Q16\.16: tested within ±([\d,]+)", re.MULTILINE)
_SEEN = re.compile(r"/core/core/(?:\w+/)?(\w+\.hpp):(\d+) (\d+)$", re.MULTILINE)
# A silent leader, to exercise COAST: no scenario has one.
_SILENCE = "fault=[{kind='radio_silent', agent=0, at_s=20.0, for_s=8.0}]"


@dataclass(frozen=True)
class Most:
    """The greatest magnitude of a file's numbers, with its line and run."""

    magnitude: float
    line: int
    run: str


@dataclass(frozen=True)
class FileRange:
    """A file of core, its stated range and its observed maximum; None if it has none."""

    file: str
    stated: float | None
    most: Most | None

    @property
    def kept(self) -> bool:
        """Whether its numbers are within the stated range, and that range has the margin."""
        if self.stated is None:
            return self.most is None
        return self.stated * MARGIN <= _END and (
            self.most is None or self.most.magnitude <= self.stated
        )


def observed(folder: Path = FOLDER) -> ctypes.CDLL:
    """Make later imports of `flotilla` use the module in `folder`.

    RuntimeError if `flotilla` was already imported.
    """
    (path,) = folder.glob("flotilla.*.so")
    if "flotilla" in sys.modules:
        raise RuntimeError("flotilla was imported before")
    spec = importlib.util.spec_from_file_location("flotilla", path)
    assert spec is not None
    assert spec.loader is not None
    sys.modules["flotilla"] = module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    library = ctypes.CDLL(str(path))
    library.q16_take_seen.restype = ctypes.c_char_p
    return library


def seen(text: str, run: str) -> dict[str, Most]:
    """Parse the module's lines `FILE:LINE RAW` of the run named `run`: maxima by file of core."""
    most: dict[str, Most] = {}
    for file, line, raw in _SEEN.findall(text):
        most = merged(most, {file: Most(int(raw) / 65536, int(line), run)})
    return most


def merged(a: Mapping[str, Most], b: Mapping[str, Most]) -> dict[str, Most]:
    """The greater of the two maxima, by file."""
    both = dict(a)
    for file, most in b.items():
        if file not in both or both[file].magnitude < most.magnitude:
            both[file] = most
    return both


def sail_all(library: ctypes.CDLL, seconds: float) -> Iterator[dict[str, Most]]:
    """Sail every scenario, at most `seconds` each; return the maxima of each run."""
    # these import flotilla, which must be the module of `observed`
    from sil.lockstep.world import all_sailed, sail  # noqa: PLC0415
    from sil.scenario import law, scenario  # noqa: PLC0415

    for path in sorted(scenario.FOLDER.glob("*.toml")):
        silence = [_SILENCE] if path.stem == "diamond" else []
        for chosen in law.LAWS:
            if (path.stem, chosen) == ("diamond_frame1", "paper"):
                continue  # it demands thousands of newtons, for which Q16 rightly enters FAULT
            whole = scenario.load(path, [*silence, "scalar='q16'"], chosen)
            one = whole.model_copy(update={"duration_s": min(whole.duration_s, seconds)})
            library.q16_take_seen()
            all_sailed(sail([one], {}))
            yield seen(library.q16_take_seen().decode(), f"{one.name}, {chosen}")


def stated(core: Path = CORE) -> dict[str, float]:
    """The tested range that each file of core states, if it does."""
    found = {}
    for path in core.rglob("*.hpp"):
        if said := _STATED.search(path.read_text(encoding="utf-8")):
            found[path.name] = float(said[1].replace(",", ""))
    return found


def rows(says: Mapping[str, float], most: Mapping[str, Most]) -> list[FileRange]:
    """Every file that states a range or had a value."""
    return [
        FileRange(file, says.get(file), most.get(file))
        for file in sorted(says.keys() | most.keys())
    ]


def for_terminal(found: Iterable[FileRange]) -> Table:
    """The table for the terminal, with margins to Q16.16's limit; violations are red."""
    grid = Table(box=box.SIMPLE_HEAD, pad_edge=False, collapse_padding=True)
    for place, head in enumerate(("file:line", "greatest", "stated", "margin", "run")):
        grid.add_column(head, justify="right" if 1 <= place <= 3 else "left", no_wrap=True)
    for row in found:
        file, most = Path(row.file).stem, row.most
        grid.add_row(
            f"{file}:{most.line}" if most else file,
            f"{most.magnitude:,.1f}" if most else "–",
            f"{row.stated:,g}" if row.stated else "none",
            f"{_END / most.magnitude:,.0f}" if most and most.magnitude else "–",
            most.run if most else "–",
            style=None if row.kept else "bold red",
        )
    return grid


def main(arguments: list[str]) -> int:
    """Run the module's command line; exit status 1 if a file exceeds its range.

    It is also 1 if a stated range has no margin, else 0.
    """
    parser = argparse.ArgumentParser(prog="tools/fixed --ranges", description=__doc__)
    parser.add_argument("--seconds", type=float, default=300.0, help="limit of each run, s (300)")
    options = parser.parse_args(arguments)
    console = Console()
    most: dict[str, Most] = {}
    runs = sail_all(observed(), options.seconds)
    for of_run in track(runs, "sailing", console=console):
        most = merged(most, of_run)
    if not most:
        print(
            "error: the module recorded no values: tools/fixed --ranges builds it", file=sys.stderr
        )
        return 1
    found = rows(stated(), most)
    console.print(for_terminal(found))
    return 0 if all(row.kept for row in found) else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
