# SPDX-License-Identifier: MIT
"""A signed apt repository: a fresh Debian installs from it, goes up and down, and is purged."""

import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.package.conftest import changed
from tests.package.root import SOURCES, Root, foreign_root, need, run
from tests.package.test_install import CONFIG, SAVED, files_of, sail_a_little

SOURCE = """Types: deb
URIs: file:/repository
Suites: stable
Components: main
Signed-By: /etc/apt/keyrings/flotilla.gpg
"""

pytestmark = pytest.mark.nightly


class Repository:
    """A folder with packages, and a key for it that nobody keeps."""

    def __init__(self, folder: Path) -> None:
        need("gpg", "apt-ftparchive")
        self.folder = folder / "repository"
        self._environment = os.environ | {"GNUPGHOME": str(folder / "gpg")}
        (folder / "gpg").mkdir(mode=0o700)
        self.key = "throw-away@flotilla.invalid"
        self._call("gpg", "--batch", "--passphrase=", "--quick-generate-key", self.key)

    def _call(self, *words: object) -> None:
        subprocess.run(list(map(str, words)), env=self._environment, check=True)

    def add(self, package: Path) -> None:
        self._call(SOURCES / "tools" / "repository", self.folder, self.key, package)

    def close(self) -> None:
        self._call("gpgconf", "--kill", "all")


@pytest.fixture
def repository(tmp_path: Path) -> Iterator[Repository]:
    found = Repository(tmp_path)
    yield found
    found.close()


@pytest.fixture
def root(tmp_path_factory: pytest.TempPathFactory, arch: str) -> Iterator[Root]:
    """A fresh Debian that knows no other repository than ours."""
    root = foreign_root(tmp_path_factory.mktemp("root"), arch, "apt")
    root.run("find", "/etc/apt", "-name", "*.list", "-delete")
    root.write("/etc/apt/sources.list.d/flotilla.sources", SOURCE)
    yield root
    root.close()


def renew(root: Root, repository: Repository) -> str:
    """Output of `apt-get update` with the repository as it is now."""
    root.run("rm", "-rf", "/repository")
    run(root.beside("cp", "-r", repository.folder, f"{root.path}/repository"))
    root.run("mkdir", "-p", "/etc/apt/keyrings")
    root.run("cp", "/repository/flotilla.gpg", "/etc/apt/keyrings/flotilla.gpg")
    return apt(root, "update", "--error-on=any")


def apt(root: Root, *words: str, check: bool = True) -> str:
    return root.run("env", "DEBIAN_FRONTEND=noninteractive", "apt-get", "-y", *words, check=check)


def version(root: Root) -> str:
    return root.run("dpkg-query", "--show", "--showformat=${Version}", "flotillad")


def test_a_boat_is_installed_goes_up_and_down_with_its_parameters_and_is_purged(
    repository: Repository, root: Root, package: Path, arch: str, tmp_path: Path
) -> None:
    before = files_of(root)
    repository.add(package)
    renew(root, repository)
    apt(root, "install", "flotillad")
    first = version(root)
    sail_a_little(root)
    root.run("sed", "-i", "s/^priority = 50/priority = 40/", CONFIG)

    repository.add(changed(package, tmp_path / f"flotillad_9.9_{arch}.deb", "9.9"))
    renew(root, repository)
    apt(root, "upgrade")
    assert version(root) == "9.9"
    assert "LAW_KX 0.3" in root.run("cat", SAVED) and "priority = 40" in root.run("cat", CONFIG)

    apt(root, "install", "--allow-downgrades", f"flotillad={first}")
    assert version(root) == first
    assert "LAW_KX 0.3" in root.run("cat", SAVED) and "priority = 40" in root.run("cat", CONFIG)

    apt(root, "purge", "flotillad")
    ours = "/etc/apt/keyrings/flotilla.gpg /etc/apt/sources.list.d/flotilla.sources"
    assert set(files_of(root)) - set(ours.split()) == set(before) - set(ours.split())


def test_apt_refuses_a_changed_package_and_a_list_that_the_key_did_not_sign(
    repository: Repository, root: Root, package: Path
) -> None:
    repository.add(package)
    file = repository.folder / "pool" / package.name
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)
    renew(root, repository)
    assert "Hash Sum mismatch" in apt(root, "install", "flotillad", check=False)
    assert not root.has("/usr/bin/flotillad")

    release = repository.folder / "dists" / "stable" / "InRelease"
    release.write_text(release.read_text().replace("Origin: Flotilla", "Origin: Flotille"))
    with pytest.raises(AssertionError, match="BADSIG"):
        renew(root, repository)


def test_a_key_that_gpg_does_not_have_is_named(repository: Repository, package: Path) -> None:
    words = [str(SOURCES / "tools" / "repository"), str(repository.folder), "nobody", str(package)]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 1
    assert "gpg's keyring has no secret key nobody" in done.stderr
    assert not repository.folder.exists()
