# SPDX-License-Identifier: MIT
"""Runs `flotilla_player` on emulated processors: a Cortex-M4, and a 64-bit ARM with Linux."""

import subprocess
from pathlib import Path

from sil import ROOT

QEMU = "qemu-system-arm"
QEMU_ARM64 = "qemu-aarch64-static"
_BUILD = ROOT / "build"
IMAGE = _BUILD / "cortex-m/firmware/flotilla_player"
ARM64 = _BUILD / "player-arm64/firmware/flotilla_player"


def _said(command: list[str], stream: bytes, timeout_s: float) -> dict[str, str]:
    run = subprocess.run(command, input=stream, capture_output=True, timeout=timeout_s, check=False)  # noqa: S603
    said = run.stdout.decode() + run.stderr.decode()
    if run.returncode != 0:
        raise RuntimeError(f"the player ended with status {run.returncode}: {said.strip()}")
    return {name: value for name, _, value in (line.partition(" ") for line in said.splitlines())}


def play(stream: bytes, image: Path = IMAGE, timeout_s: float = 600.0) -> dict[str, str]:
    """Run the image on a Cortex-M4 that counts instructions; return its output by name.

    RuntimeError if it fails.
    """
    command = [
        *(QEMU, "-machine", "mps2-an386", "-icount", "shift=0"),
        *("-display", "none", "-monitor", "none", "-serial", "none"),
        *("-semihosting-config", "enable=on,target=native", "-kernel", str(image)),
    ]
    return _said(command, stream, timeout_s)


def play_arm64(stream: bytes, program: Path = ARM64, timeout_s: float = 600.0) -> dict[str, str]:
    """Run the program for 64-bit ARM, without counting instructions."""
    return _said([QEMU_ARM64, str(program)], stream, timeout_s)
