# SPDX-License-Identifier: MIT
"""The packages of a Raspberry Pi in a Debian of its processor: qemu, binfmt_misc, mmdebstrap."""

import re
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.package.conftest import build
from tests.package.root import SOURCES, Root, foreign_root, need, run

LENIENT = Path(__file__).with_name("lenient_socket.cpp")

pytestmark = pytest.mark.nightly


@pytest.fixture(scope="module")
def root(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Root]:
    """A Raspberry Pi's Debian, without the package."""
    root = foreign_root(tmp_path_factory.mktemp("root"), "arm64")
    yield root
    root.close()


@pytest.mark.parametrize(("arch", "triplet"), [("arm64", "aarch64"), ("armhf", "arm")])
def test_lintian_finds_no_error_and_no_warning(arch: str, triplet: str) -> None:
    need("lintian", f"{triplet}-linux-gnu{'eabihf' if arch == 'armhf' else ''}-g++")
    run(["lintian", "--allow-root", "--fail-on=error,warning", str(build(arch))])


def test_an_arm64_boat_is_installed_sails_on_loopback_and_is_purged(
    root: Root, tmp_path: Path
) -> None:
    need("aarch64-linux-gnu-g++")
    package = build("arm64")
    root.put(package, "/tmp/flotillad.deb")
    root.run("dpkg", "--install", "/tmp/flotillad.deb")
    assert root.run("uname", "-m").strip() == "aarch64"
    revision = re.search(r"\.([0-9a-f]{8})", package.name)
    assert revision
    assert root.run("flotillad", "--version").strip() == f"flotillad 0.1 ({revision[1]})"
    assert "dialout" in root.run("id", "flotilla")

    said = run(sail(root, tmp_path))
    assert "pushes: (" in said and "status 0" in said

    root.run("dpkg", "--purge", "flotillad")
    assert not root.has("/usr/bin/flotillad") and not root.has("/etc/flotilla")


def sail(root: Root, folder: Path) -> list[str]:
    """The command line that sails the root's flotillad in the root's network."""
    library = lenient_socket(folder, "aarch64-linux-gnu-g++")
    root.put(library, "/tmp/lenient_socket.so")
    root.run("mkdir", "--mode=777", "/tmp/state")
    where = ["chroot", str(root.path), "env", "LD_PRELOAD=/tmp/lenient_socket.so"]
    words = [sys.executable, "-m", "tests.package.sail", str(folder), "/usr/bin/flotillad"]
    return root.beside("env", f"--chdir={SOURCES}", *words, "/tmp/state", *where)


def lenient_socket(folder: Path, compiler: str) -> Path:
    """The library that makes up for socket options that qemu lacks."""
    library = folder / "lenient_socket.so"
    run([compiler, "-shared", "-fPIC", "-o", str(library), str(LENIENT)])
    return library
