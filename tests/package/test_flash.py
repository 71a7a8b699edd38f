# SPDX-License-Identifier: MIT
"""tools/flash and a boat: real ssh, packages and flotillad; only systemd is replaced."""

import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.package.conftest import changed
from tests.package.root import SOURCES, Root, need, own_root, run

PORT = 2222
SAVED = "/var/lib/flotilla/parameters.txt"
CONFIG = "/etc/flotilla/boat.toml"
#: A bus that needs no CAN in the kernel.
SHIPPED = (SOURCES / "firmware" / "linux" / "boat.toml").read_text()
BOAT_TOML = SHIPPED.replace("socketcan:can0", "mcast:0").replace("priority = 50", "priority = 0")

pytestmark = pytest.mark.nightly


class Harbour:
    """The boat's computer with sshd, and an ssh configuration that names it `boat`."""

    def __init__(self, root: Root, folder: Path) -> None:
        self.root = root
        self._folder = folder
        run(["ssh-keygen", "-q", "-t", "ed25519", "-N", "", "-f", str(folder / "key")])
        root.write("/root/.ssh/authorized_keys", (folder / "key.pub").read_text(), "0600")
        root.write(
            "/usr/local/sbin/systemctl", (Path(__file__).parent / "systemctl").read_text(), "0755"
        )
        root.run("mkdir", "-p", "/run/systemd/system", "/run/sshd")
        root.run("ssh-keygen", "-A")
        options = ["PermitRootLogin=yes", "ListenAddress=127.0.0.1", "StrictModes=no", "UsePAM=no"]
        options.append("Subsystem=sftp internal-sftp")
        words = [word for option in options for word in ("-o", option)]
        root.run("/usr/sbin/sshd", "-f", "/dev/null", "-p", PORT, *words)
        config = folder / "config"
        config.write_text(f"""Host boat
            HostName 127.0.0.1
            Port {PORT}
            User root
            IdentityFile {folder / "key"}
            StrictHostKeyChecking no
            UserKnownHostsFile /dev/null
            LogLevel ERROR\n""")
        for program in ("ssh", "scp"):
            wrapper = folder / "bin" / program
            wrapper.parent.mkdir(exist_ok=True)
            wrapper.write_text(f'#!/bin/sh\nexec /usr/bin/{program} -F {config} "$@"\n')
            wrapper.chmod(0o755)

    def flash(self, package: Path) -> tuple[int, str]:
        """Exit status and output of tools/flash, without tools/setup."""
        path = f"PATH={self._folder / 'bin'}:{os.environ['PATH']}"
        flash = SOURCES / "tools" / "flash.py"
        done = subprocess.run(
            self.root.beside("env", path, sys.executable, flash, "boat", package),
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            timeout=200,
            check=False,
        )
        return done.returncode, done.stdout

    def version(self) -> str:
        return self.root.run("dpkg-query", "--show", "--showformat=${Version}", "flotillad")


@pytest.fixture(scope="module")
def harbour(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Harbour]:
    need("ssh", "sshd")
    root = own_root(tmp_path_factory.mktemp("root"), own_network=True)
    yield Harbour(root, tmp_path_factory.mktemp("ssh"))
    root.close()


@pytest.fixture(scope="module")
def good(package: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The package with a configuration that needs no CAN."""
    folder = tmp_path_factory.mktemp("good")
    version = package.name.split("_")[1]
    return changed(package, folder / "good.deb", version, boat_toml=BOAT_TOML)


def newer(good: Path, name: str, **files: str) -> Path:
    """A later build of the same commit."""
    version = run(["dpkg-deb", "--field", str(good), "Version"]).strip()
    return changed(good, good.parent / f"{name}.deb", f"{version}+later", **files)


def test_a_bare_computer_becomes_a_boat_that_answers(harbour: Harbour, good: Path) -> None:
    status, words = harbour.flash(good)
    assert status == 0, words
    assert "boat answers as flotillad 0.1" in words
    assert harbour.root.has("/var/cache/flotilla/flotillad.deb")


def test_a_later_package_replaces_the_earlier_one(harbour: Harbour, good: Path) -> None:
    status, words = harbour.flash(newer(good, "later"))
    assert status == 0, words
    assert harbour.version().endswith("+later")


def test_a_program_of_another_version_is_rolled_back(harbour: Harbour, good: Path) -> None:
    assert harbour.flash(good)[0] == 0
    before = harbour.version()
    wrong = newer(good, "wrong", flotillad='#!/bin/sh\necho "flotillad 0.0 (00000000)"\n')
    status, words = harbour.flash(wrong)
    assert status == 1 and "expected flotillad 0.1" in words, words
    assert f"back: {before}" in words and harbour.version() == before


def test_a_boat_that_does_not_answer_gets_its_old_package_and_its_parameters_back(
    harbour: Harbour, good: Path
) -> None:
    assert harbour.flash(good)[0] == 0
    before, config = harbour.version(), harbour.root.run("cat", CONFIG)
    saved = "LAW_KX 0.3\n"  # by the operator: a new boat has no such file
    harbour.root.write(SAVED, saved, "0640")
    mute = f"#!/bin/sh\n[ $1 = --version ] && exec /usr/bin/env echo '{told(good)}'\n"
    mute += f"echo spoiled > {SAVED}; exec sleep 1000\n"
    status, words = harbour.flash(newer(good, "mute", flotillad=mute))
    assert status == 1 and "no HEARTBEAT" in words, words
    assert f"back: {before}" in words and harbour.version() == before
    assert harbour.root.run("cat", CONFIG) == config
    assert harbour.root.run("cat", SAVED) == saved
    assert harbour.flash(good)[0] == 0, "and it answers again"


def told(good: Path) -> str:
    """The version that the package's program prints."""
    revision = run(["dpkg-deb", "--field", str(good), "Version"]).split(".")[2][:8]
    return f"flotillad 0.1 ({revision})"


def test_a_lost_connection_rolls_back(harbour: Harbour, good: Path) -> None:
    assert harbour.flash(good)[0] == 0
    before = harbour.version()
    harbour.root.put(newer(good, "lost"), "/tmp/flotillad.deb")
    harbour.root.put(SOURCES / "tools" / "flash-install", "/tmp/flash-install")
    said = harbour.root.run("bash", "/tmp/flash-install", "/tmp", check=False)
    assert "installed: flotillad 0.1" in said and f"back: {before}" in said
    assert harbour.version() == before
