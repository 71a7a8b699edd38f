# SPDX-License-Identifier: MIT
"""A Debian root to install into: this machine's own under an overlay, or another processor's.

Mounts, processes and, on request, the network are in namespaces of their own; all of it is
gone when the root is closed, or with the test's process.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

SOURCES = Path(__file__).parents[2]
CACHE = SOURCES / "build" / "roots"
SUITE = "bookworm"
#: By Debian's architecture: the interpreter for binfmt_misc.
INTERPRETERS = {"arm64": "qemu-aarch64", "armhf": "qemu-arm"}
BINFMT = Path("/proc/sys/fs/binfmt_misc")
PATIENCE_S = 300.0
TIMED_OUT = 124  # exit status of timeout(1)

OVERLAY = """
mount -t overlay -o lowerdir=/,upperdir=upper,workdir=work overlay root
rm -f root/usr/sbin/policy-rc.d
"""
NETWORK = "ip link set lo up multicast on && ip route add 239.0.0.0/8 dev lo src 127.0.0.1"


def as_root() -> list[str]:
    """Command prefix to run as root; skips the test if that is impossible."""
    if os.geteuid() == 0:
        return []
    words = ["sudo", "-n"]
    if not shutil.which("sudo") or subprocess.run([*words, "true"], check=False).returncode:
        pytest.skip("SKIPPED: installing packages needs root, or sudo without a password")
    return words


def need(*programs: str) -> None:
    """Skip the test if one of the programs is missing."""
    os.environ["PATH"] += ":/usr/sbin:/sbin"
    missing = [program for program in programs if shutil.which(program) is None]
    if missing:
        pytest.skip(f"SKIPPED: not on this machine: {', '.join(missing)}")


class Root:
    """A root; `fill` is a shell script, run in a tmpfs, that makes the folder `root`."""

    def __init__(self, place: Path, fill: str, *, own_network: bool) -> None:
        self.path = place / "root"
        script = f"""set -e
            mount -t tmpfs tmpfs {place}; cd {place}; mkdir upper work root
            {fill}
            mount -t proc proc root/proc; mount --rbind /dev root/dev
            mount -t tmpfs tmpfs root/run
            {NETWORK if own_network else ":"}
            echo ready; read -r _ || true"""
        kinds = ["--mount", "--pid", *(["--net"] if own_network else [])]
        words = ["unshare", *kinds, "--fork", "--kill-child", "bash", "-c", script]
        self._keeper = subprocess.Popen(
            [*as_root(), *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        assert self._keeper.stdout is not None and self._keeper.stderr is not None
        if self._keeper.stdout.readline() != "ready\n":
            pytest.skip(f"SKIPPED: no root can be made here: {self._keeper.stderr.read()}")
        self._enter = [*as_root(), "nsenter", f"--target={first_process(self._keeper.pid)}"]
        self._enter += [*kinds, "--"]

    def close(self) -> None:
        """End all processes in it: its first process waits for the end of its input."""
        self._keeper.communicate("", timeout=PATIENCE_S)

    def words(self, *command: object) -> list[str]:
        """The command line that runs a command in the root."""
        return [*self._enter, "chroot", str(self.path), *map(str, command)]

    def beside(self, *command: object) -> list[str]:
        """The command line that runs a local command with the root's folder and network."""
        return [*self._enter, *map(str, command)]

    def run(self, *command: object, check: bool = True) -> str:
        """The output of a command in the root."""
        return run(self.words("env", "LC_ALL=C.UTF-8", *command), check)

    def put(self, file: Path, target: str) -> None:
        """Copies a file of this machine into the root."""
        run(self.beside("cp", file, f"{self.path}{target}"))

    def write(self, target: str, text: str, mode: str = "0644") -> None:
        words = self.words("install", "-D", "-m", mode, "/dev/stdin", target)
        subprocess.run(words, input=text, text=True, check=True, timeout=PATIENCE_S)

    def has(self, path: str) -> bool:
        return subprocess.run(self.words("test", "-e", path), check=False).returncode == 0


def run(words: Sequence[str], check: bool = True) -> str:
    """The output of a command; the error contains it if the command fails."""
    done = subprocess.run(
        words,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        timeout=PATIENCE_S,
    )
    assert not check or done.returncode == 0, f"{words}: {done.returncode}\n{done.stdout}"
    return done.stdout


def first_process(pid: int) -> int:
    """The first process of the process namespace made by an `unshare` at or below `pid`."""
    while True:
        name = Path(f"/proc/{pid}/comm").read_text()
        pid = int(Path(f"/proc/{pid}/task/{pid}/children").read_text().split()[0])
        if name == "unshare\n":
            return pid


def own_root(place: Path, *, own_network: bool = False) -> Root:
    """This machine's Debian or Ubuntu under an overlay that takes all writes."""
    need("dpkg", "unshare", "nsenter", "ip", "systemd-sysusers", "deb-systemd-helper")
    return Root(place, OVERLAY, own_network=own_network)


def foreign_root(place: Path, arch: str, *extra: str) -> Root:
    """A fresh Debian, mostly of another processor, with extra packages.

    Its archive stays in build/roots.
    """
    need("mmdebstrap", "arch-test", "unshare", "nsenter")
    understand(arch)
    archive = CACHE / f"{'-'.join((SUITE, arch, *extra))}.tar"
    if not archive.exists():
        CACHE.mkdir(parents=True, exist_ok=True)
        made = archive.with_suffix(".new.tar")
        words = ["timeout", f"{PATIENCE_S:.0f}"]
        words += ["mmdebstrap", f"--arch={arch}", "--variant=essential"]
        words += [f"--include={','.join(('systemd', 'libstdc++6', *extra))}", SUITE, str(made)]
        done = subprocess.run([*as_root(), *words], capture_output=True, text=True, check=False)
        if done.returncode:
            made.unlink(missing_ok=True)
            late = f"; it was given {PATIENCE_S:.0f} s" if done.returncode == TIMED_OUT else ""
            pytest.skip(f"SKIPPED: mmdebstrap fails here: {done.stderr[-500:]}{late}")
        made.rename(archive)
    return Root(place, f"tar --directory=root --extract --file={archive}", own_network=True)


def understand(arch: str) -> None:
    """Make the kernel run that architecture's programs by qemu; skips the test if it cannot."""
    if subprocess.run(["arch-test", arch], check=False, capture_output=True).returncode == 0:
        return
    interpreter = INTERPRETERS[arch]
    file = Path(f"/usr/lib/binfmt.d/{interpreter}.conf")
    if not file.exists():
        pytest.skip("SKIPPED: not on this machine: qemu-user-static")
    script = f"""test -e {BINFMT}/register || mount -t binfmt_misc binfmt_misc {BINFMT}
        tail -n 1 {file} > {BINFMT}/register"""
    done = subprocess.run(
        [*as_root(), "sh", "-c", script], capture_output=True, text=True, check=False
    )
    if subprocess.run(["arch-test", arch], check=False, capture_output=True).returncode:
        pytest.skip(f"SKIPPED: this kernel runs no {arch}, binfmt_misc: {done.stderr}")
