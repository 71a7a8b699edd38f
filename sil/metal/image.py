# SPDX-License-Identifier: MIT
"""Runs the image on an emulated Cortex-M4 that counts its instructions."""

import subprocess
from pathlib import Path

QEMU = "qemu-system-arm"


def play(image: Path, stream: bytes, timeout_s: float = 600.0) -> dict[str, str]:
    """What the image prints, by name. RuntimeError where it does not end well."""
    command = [
        *(QEMU, "-machine", "mps2-an386", "-icount", "shift=0"),
        *("-display", "none", "-monitor", "none", "-serial", "none"),
        *("-semihosting-config", "enable=on,target=native", "-kernel", str(image)),
    ]
    run = subprocess.run(command, input=stream, capture_output=True, timeout=timeout_s, check=False)  # noqa: S603
    said = run.stdout.decode() + run.stderr.decode()
    if run.returncode != 0:
        raise RuntimeError(f"the image ended with status {run.returncode}: {said.strip()}")
    return dict(line.split(" ", 1) for line in said.splitlines())
