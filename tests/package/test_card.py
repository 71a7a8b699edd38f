# SPDX-License-Identifier: MIT
"""The layer of a boat's SD card, built by bdebstrap as rpi-image-gen does; without partitions."""

from pathlib import Path

import pytest

from tests.package.root import SOURCES, SUITE, Root, as_root, need, run
from tests.package.test_install import ENABLED

CARD = SOURCES / "firmware" / "linux" / "card"
CONFIG = "/persistent/flotilla/boat.toml"


@pytest.mark.nightly
def test_a_card_starts_flotillad_with_the_files_of_the_shared_partition(
    package: Path, tmp_path: Path
) -> None:
    need("bdebstrap", "mmdebstrap", "unshare", "nsenter")
    words = ["bdebstrap", "--config=layer/flotilla.yaml", f"--suite={SUITE}", "--packages=apt"]
    words += ["--variant=essential", "--name=card", f"--output={tmp_path}", "--target=root.tar"]
    run([*as_root(), "env", f"--chdir={CARD}", *words])
    (tmp_path / "place").mkdir()
    fill = f"tar --directory=root --extract --file={tmp_path / 'root.tar'}"
    root = Root(tmp_path / "place", fill, own_network=True)
    try:
        root.run("systemd-tmpfiles", "--create", "flotilla.conf")
        assert root.has(ENABLED)
        text = root.run("cat", CONFIG)
        assert 'state-dir = "/persistent/flotilla"' in text
        assert 'log = "/persistent/flotilla/log"' in text
        user = ("setpriv", "--reuid=flotilla", "--regid=flotilla", "--init-groups")
        root.run(*user, "flotillad", "--check", "--config", CONFIG)
        root.run(*user, "test", "-w", "/persistent/flotilla/log")
        version = package.name.split("_")[1]
        assert version in root.run("dpkg-query", "--show", "flotillad")
        unit = root.run("systemd-analyze", "cat-config", "systemd/system/flotillad.service")
        assert unit.count("ExecStart=") == 3 and f"--config {CONFIG}" in unit
    finally:
        root.close()
