# SPDX-License-Identifier: MIT
"""Feeds a recording to its boats again: the same bytes must give the same answers, bit for bit.

Exit status: 0 if all answers are equal, 1 if one differs, 2 if the file cannot be replayed.
"""

import argparse
from collections.abc import Sequence
from pathlib import Path

EXAMPLES = ("flotilla replay out/diamond",)


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("recording", type=Path, help="the recording.bin of a run, or its folder")


def main(options: argparse.Namespace, _: Sequence[str]) -> int:
    """Replay the recording and compare the answers."""
    from sil.lockstep.recording import Recording
    from sil.lockstep.replay import replay

    path: Path = options.recording
    if path.is_dir():
        path /= "recording.bin"
        if not path.exists():
            raise ValueError(
                f"{path.parent} has no recording: only flotilla run leaves one (for a run of a "
                "campaign: flotilla campaign … --run NUMBER)"
            )
    recording = Recording(path)
    first = replay(recording)
    for boat, t_us in enumerate(first, start=1):
        same = "the same, bit for bit" if t_us < 0 else f"different, first at {t_us * 1e-6:.3f} s"
        print(f"boat {boat}: {same}")
    print(f"digest {recording.digest()}")
    return int(any(t_us >= 0 for t_us in first))
