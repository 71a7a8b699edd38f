# SPDX-License-Identifier: MIT
"""Packages of this tree, built once, and altered copies of them."""

import fcntl
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.package.root import SOURCES, Root, need, own_root, run


def build(arch: str) -> Path:
    """Build the package with tools/package, one build at a time across test runs."""
    with Path("/tmp/flotilla-package.lock").open("a") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        said = subprocess.run(
            [SOURCES / "tools" / "package", arch], check=True, stdout=subprocess.PIPE, text=True
        ).stdout
    return SOURCES / said.strip()


@pytest.fixture(scope="session")
def arch() -> str:
    need("dpkg")
    return run(["dpkg", "--print-architecture"]).strip()


@pytest.fixture(scope="session")
def package(arch: str) -> Path:
    """The package for this machine."""
    return build(arch)


@pytest.fixture(scope="session")
def image(arch: str) -> Path:
    """The container's image for this machine."""
    return build(f"oci-{arch}")


@pytest.fixture
def root(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Root]:
    """A root with this machine's Debian, without the package."""
    root = own_root(tmp_path_factory.mktemp("root"))
    yield root
    root.close()


def changed(package: Path, target: Path, version: str, **files: str) -> Path:
    """A copy of the package with another version and other `files` (name: content).

    `name` is the file's name, with _ for characters that Python does not allow.
    """
    folder = target.parent / f"{target.stem}.folder"
    run(["dpkg-deb", "--raw-extract", str(package), str(folder)])
    control = folder / "DEBIAN" / "control"
    lines = control.read_text().splitlines()
    control.write_text(
        "".join(
            f"Version: {version}\n" if line.startswith("Version:") else f"{line}\n"
            for line in lines
        )
    )
    for name, content in files.items():
        files_there = [path for path in folder.rglob("*") if path.is_file()]
        file = next(path for path in files_there if path.name.replace(".", "_") == name)
        file.write_text(content)
    run(["dpkg-deb", "--root-owner-group", "-Zgzip", "--build", str(folder), str(target)])
    shutil.rmtree(folder)
    return target
