# SPDX-License-Identifier: MIT
"""The package on a Debian: clean installation and removal; an operator's files survive."""

import re
from pathlib import Path

import pytest

from tests.package.conftest import changed
from tests.package.root import Root, need, run

CONFIG = "/etc/flotilla/boat.toml"
BIT_RATE = "/etc/systemd/network/60-flotilla-can0.network"
SAVED = "/var/lib/flotilla/parameters.txt"
LOG = "/var/log/flotilla/mavlink0-00001.tlog"
ENABLED = "/etc/systemd/system/multi-user.target.wants/flotillad.service"


def install(root: Root, package: Path) -> None:
    root.put(package, "/tmp/flotillad.deb")
    root.run("dpkg", "--force-confdef", "--force-confold", "--install", "/tmp/flotillad.deb")


def files_of(root: Root) -> list[str]:
    """All files with flotilla in their name."""
    places = "/etc /lib/systemd /usr/bin /usr/lib/sysusers.d /usr/share/doc /usr/share/man"
    places += " /var/lib/flotilla /var/log/flotilla /var/lib/systemd"
    words = ["find", *places.split(), "-xdev", "-name", "*flotilla*"]
    return [line for line in root.run(*words, check=False).splitlines() if line[0] == "/"]


def sail_a_little(root: Root) -> None:
    """Create the files that a boat and its operator leave behind."""
    for file, text in ((SAVED, "LAW_KX 0.3\n"), (LOG, "…")):
        root.write(file, text, "0640")


@pytest.mark.nightly
def test_lintian_finds_no_error_and_no_warning(package: Path) -> None:
    need("lintian")
    said = run(["lintian", "--allow-root", "--fail-on=error,warning", str(package)])
    assert not re.search("^[EW]:", said, re.MULTILINE), said


def test_a_clean_installation_has_its_user_and_starts_with_the_machine(
    root: Root, package: Path
) -> None:
    install(root, package)
    user = root.run("id", "flotilla")
    assert "dialout" in user and "(flotilla)" in user
    assert root.run("getent", "passwd", "flotilla").strip().endswith("/nologin")
    assert root.has(ENABLED)
    version = root.run("flotillad", "--version").strip()
    revision = re.search(r"\.([0-9a-f]{8})", package.name)
    assert revision and version == f"flotillad 0.1 ({revision[1]})"
    assert root.run("dpkg", "--verify", "flotillad") == ""


@pytest.mark.nightly
def test_the_bit_rate_of_can0_is_dronecans(root: Root, package: Path) -> None:
    install(root, package)
    need("systemd-analyze")
    text = root.run("cat", BIT_RATE)
    assert "Name=can0" in text and "BitRate=1M" in text
    assert "Wants=systemd-networkd.service" in root.run(
        "cat", "/lib/systemd/system/flotillad.service"
    )


@pytest.mark.nightly
def test_an_upgrade_keeps_the_operators_configuration_and_parameters(
    root: Root, package: Path, tmp_path: Path
) -> None:
    install(root, changed(package, tmp_path / "old.deb", "0.0"))
    sail_a_little(root)
    root.run("sed", "-i", "s/^priority = 50/priority = 40/", CONFIG)
    root.run("sed", "-i", "s/BitRate=1M/BitRate=500K/", BIT_RATE)
    root.run("systemctl", "disable", "flotillad")
    install(root, changed(package, tmp_path / "new.deb", "9.9", boat_toml="priority = 1\n"))
    assert "9.9" in root.run("dpkg-query", "--show", "flotillad")
    assert "priority = 40" in root.run("cat", CONFIG)
    assert "BitRate=500K" in root.run("cat", BIT_RATE)
    assert "LAW_KX 0.3" in root.run("cat", SAVED)
    assert not root.has(ENABLED)


@pytest.mark.nightly
def test_an_upgrade_replaces_an_unchanged_configuration(
    root: Root, package: Path, tmp_path: Path
) -> None:
    install(root, package)
    install(root, changed(package, tmp_path / "new.deb", "9.9", boat_toml="priority = 1\n"))
    assert root.run("cat", CONFIG) == "priority = 1\n"


@pytest.mark.nightly
def test_a_removed_boat_comes_back_as_it_was(root: Root, package: Path) -> None:
    install(root, package)
    sail_a_little(root)
    root.run("sed", "-i", "s/^priority = 50/priority = 40/", CONFIG)
    root.run("dpkg", "--remove", "flotillad")
    assert not root.has("/usr/bin/flotillad")
    assert root.has(SAVED) and root.has(LOG)
    install(root, package)
    assert "priority = 40" in root.run("cat", CONFIG)
    assert root.has(ENABLED) and root.has("/usr/bin/flotillad")


@pytest.mark.parametrize("removed_before", [False, pytest.param(True, marks=pytest.mark.nightly)])
def test_a_purge_leaves_nothing_but_the_user(
    root: Root, package: Path, *, removed_before: bool
) -> None:
    before = files_of(root)
    install(root, package)
    assert len(files_of(root)) > len(before) + 6
    sail_a_little(root)
    if removed_before:
        root.run("dpkg", "--remove", "flotillad")
    root.run("dpkg", "--purge", "flotillad")
    assert files_of(root) == before


@pytest.mark.nightly
def test_a_purge_leaves_the_operators_signing_key(root: Root, package: Path) -> None:
    install(root, package)
    root.write("/etc/flotilla/signing.key", "secret", "0600")
    root.run("dpkg", "--purge", "flotillad")
    assert root.run("ls", "/etc/flotilla").split() == ["signing.key"]
