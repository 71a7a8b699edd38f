# SPDX-License-Identifier: MIT
"""Plays a boat's recording on x86-64, AArch64 and Cortex-M4: digests, instructions, memory."""

import argparse
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import fmean, median

from rich import box
from rich.console import Console
from rich.table import Table

from sil import ROOT
from sil.examine.metal.image import IMAGE, play, play_arm64
from sil.examine.metal.size import sizes
from sil.examine.metal.stream import stream_of
from sil.lockstep.recording import Recording
from sil.lockstep.world import sail
from sil.scenario import scenario

BENCH = ROOT / "build/release/flotilla_bench"
FLASH, RAM = 200_000, 48_000


def _stream(recording: Path | None, boat: int, seconds: float) -> tuple[bytes, str]:
    if recording is not None:
        return stream_of(Recording(recording), boat - 1, seconds)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "recording.bin"
        sail([scenario.load("diamond", [f"duration_s={seconds}", "scalar='q16'"])], {}, record=path)
        return stream_of(Recording(path), boat - 1, seconds)


def steady_stream(ticks: int) -> bytes:
    """The input of a boat that receives its own and its leader's state before every tick only."""
    command = [str(BENCH), "stream", str(ticks)]
    return subprocess.run(command, check=True, capture_output=True).stdout  # noqa: S603


def _columns(*heads: str) -> Table:
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for place, head in enumerate(heads):
        table.add_column(head, justify="right" if place else "left", no_wrap=True)
    return table


def main(arguments: list[str]) -> int:
    """Run the module's command line; exit status 0 if all outputs are equal and the image fits."""
    parser = argparse.ArgumentParser(prog="tools/metal", description=__doc__)
    parser.add_argument(
        "recording", type=Path, nargs="?", help="recording.bin of a q16 run (diamond's, sailed)"
    )
    parser.add_argument("--boat", type=int, default=1, help="number of the boat: 1, 2, …")
    parser.add_argument(
        "--seconds", type=float, default=20.0, help="seconds of the recording to play (20)"
    )
    options = parser.parse_args(arguments)
    console = Console()
    stream, here = _stream(options.recording, options.boat, options.seconds)
    said, steady = play(stream), play(steady_stream(1000))
    digests = {"x86-64": here, "aarch64": play_arm64(stream)["digest"], "Cortex-M4": said["digest"]}
    table = _columns("processor", "digest")
    for processor, digest in digests.items():
        table.add_row(processor, digest)
    console.print(table)

    # At the median tick no telemetry is due; the mean includes telemetry.
    table = _columns("instructions of a tick in FORMATION", "least", "median", "mean")
    for name, told in (("own, leader, reference heard", steady), ("the recording's", said)):
        each = [int(tick) for tick in told["instructions_driving"].split()]
        figures = [f"{of(each):,.0f}" for of in (min, median, fmean)] if each else ["–"] * 3
        table.add_row(name, *figures)
    console.print(table)

    flash, ram = sizes(IMAGE.with_suffix(".map"))
    ram["stack"] = int(said["stack_bytes"])
    table = _columns("bytes", "flash", "RAM")
    for room in sorted(flash.keys() | ram.keys(), key=lambda name: -flash[name]):
        table.add_row(room, f"{flash[room]:,}", f"{ram[room]:,}")
    table.add_section()
    table.add_row("all", f"{flash.total():,}", f"{ram.total():,}")
    table.add_row("limit", f"{FLASH:,}", f"{RAM:,}")
    console.print(table)
    same = len(set(digests.values())) == 1
    print("the same digest on all three" if same else "the digests differ")
    return 0 if same and flash.total() <= FLASH and ram.total() <= RAM else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
