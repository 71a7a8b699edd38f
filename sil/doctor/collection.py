# SPDX-License-Identifier: MIT
"""Collects everything for a fault report in one file.

The file has findings, configuration, parameters, logs and versions, but never a key: the signing
key's file is left out wherever it is, and so is every file that contains its bytes.
"""

import io
import json
import shutil
import subprocess
import tarfile
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from sil.common import files
from sil.doctor.boat_file import Boat
from sil.doctor.checkup import as_json
from sil.doctor.computer import Computer
from sil.doctor.finding import Finding

_MOST_BYTES = 64 << 20  # limit of the logs, newest first
_FILES = ("/etc/os-release", "/etc/systemd/network/60-flotilla-can0.network", "/proc/cpuinfo")
_COMMANDS = {
    "journal": "journalctl --unit flotillad --lines 5000 --no-pager",
    "kernel": "dmesg --ctime",
    "links": "ip -details -statistics link",
    "addresses": "ip address",
    "package": "dpkg-query --status flotillad",
    "crashes": "coredumpctl list flotillad --no-pager",
    "kernel_version": "uname -a",
}


def collect(
    computer: Computer, config: str, boat: Boat | None, findings: Sequence[Finding], out: Path
) -> list[str]:
    """Write the whole archive or none; return the names in it. OSError if it cannot be written."""
    secret = _secret(computer, boat)
    names = []
    with files.whole(out) as file, tarfile.open(out, "w:gz", fileobj=file) as archive:
        for name, data in _contents(computer, config, boat, findings):
            if any(one and one in data for one in secret):
                continue
            entry = tarfile.TarInfo(f"flotilla-report/{name}")
            entry.size = len(data)
            archive.addfile(entry, io.BytesIO(data))
            names.append(name)
    return names


def _secret(computer: Computer, boat: Boat | None) -> list[bytes]:
    """The signing key in each form that a file could contain."""
    if boat is None or not boat.signing_key:
        return []
    try:
        data = computer.at(boat.signing_key).read_bytes().strip()
    except OSError:
        return []
    forms = [data, data.hex().encode(), data.hex().upper().encode()]
    with suppress(ValueError):
        forms.append(bytes.fromhex(data.decode()))
    return [form for form in forms if len(form) >= 16]


def _contents(
    computer: Computer, config: str, boat: Boat | None, findings: Sequence[Finding]
) -> Iterator[tuple[str, bytes]]:
    yield "doctor.json", json.dumps(as_json(findings), indent=1).encode()
    for name in (config, *_FILES):
        yield from _file(computer.at(name), name.lstrip("/"))
    for name, command in _COMMANDS.items():
        yield f"commands/{name}.txt", _said(command)
    if boat is None:
        return
    key = computer.at(boat.signing_key) if boat.signing_key else None
    for path in sorted(computer.at(boat.state_dir).glob("*")):
        if path != key:
            yield from _file(path, f"state/{path.name}")
    if boat.log:
        yield from _logs(computer.at(boat.log), key)


def _logs(folder: Path, key: Path | None) -> Iterator[tuple[str, bytes]]:
    """The newest logs, as many as fit into the limit."""
    files = [path for path in folder.glob("*") if path.is_file() and path != key]
    left = _MOST_BYTES
    for path in sorted(files, key=lambda file: -file.stat().st_mtime):
        left -= path.stat().st_size
        if left >= 0:
            yield from _file(path, f"log/{path.name}")


def _file(path: Path, name: str) -> Iterator[tuple[str, bytes]]:
    try:
        yield name, path.read_bytes()
    except OSError:
        return  # the folder is missing or unreadable: doctor.json reports that


def _said(command: str) -> bytes:
    """The output of a command, or the reason why there is none."""
    words = command.split()
    program = shutil.which(words[0])
    if program is None:
        return f"no {words[0]} on this computer\n".encode()
    try:
        done = subprocess.run(  # noqa: S603
            [program, *words[1:]],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            check=False,
            timeout=30,
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"{error}\n".encode()
    return done.stdout
