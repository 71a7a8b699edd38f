# SPDX-License-Identifier: MIT
"""A boat's recorded stream on an emulated Cortex-M4: digest, instructions, stack, size by room."""

import argparse
import sys
import tempfile
from pathlib import Path

from sil import scenario
from sil.metal.image import play
from sil.metal.size import sizes
from sil.metal.stream import stream_of
from sil.recording import Recording
from sil.world import sail

ROOT = Path(__file__).resolve().parents[2]
IMAGE = ROOT / "build/cortex-m/firmware/flotilla_player"


def _stream(recording: Path | None, boat: int, seconds: float) -> tuple[bytes, str]:
    if recording is not None:
        return stream_of(Recording(recording), boat - 1, seconds)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "recording.bin"
        sail([scenario.load("diamond", [f"duration_s={seconds}"])], {}, record=path)
        return stream_of(Recording(path), boat - 1, seconds)


def _print_sizes(linker_map: Path) -> None:
    flash, ram = sizes(linker_map)
    print(f"\n{'bytes':12s}{'flash':>10s}{'RAM':>10s}")
    for room in sorted(flash.keys() | ram.keys(), key=lambda name: -flash[name]):
        print(f"{room:12s}{flash[room]:10d}{ram[room]:10d}")
    print(f"{'all':12s}{flash.total():10d}{ram.total():10d}")


def main(arguments: list[str]) -> int:
    """Exit status: 0 the recorded boat's digest, 1 another one."""
    parser = argparse.ArgumentParser(prog="tools/metal", description=__doc__)
    parser.add_argument("recording", type=Path, nargs="?", help="recording.bin (diamond's, sailed)")
    parser.add_argument("--boat", type=int, default=1, help="1, 2, …")
    parser.add_argument("--seconds", type=float, default=20.0, help="of the recording")
    options = parser.parse_args(arguments)
    stream, expected = _stream(options.recording, options.boat, options.seconds)
    said = play(IMAGE, stream)
    for name, value in said.items():
        print(f"{name:24s}{value}")
    _print_sizes(IMAGE.with_suffix(".map"))
    same = said["digest"] == expected
    print("\nthe digest is the recorded boat's" if same else f"\nrecorded digest {expected}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
