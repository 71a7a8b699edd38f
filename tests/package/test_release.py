# SPDX-License-Identifier: MIT
"""Releases: the same commit gives the same bytes, and the lists beside them are true."""

import hashlib
import json
import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest
from spdx_tools.spdx.parser.json.json_parser import parse_from_file
from spdx_tools.spdx.validation.document_validator import validate_full_spdx_document

from tests.package.conftest import build
from tests.package.root import SOURCES, run


def digest(file: Path) -> str:
    return hashlib.sha256(file.read_bytes()).hexdigest()


def parts(artefact: Path) -> dict[str, str]:
    """Versions by name, from the list beside an artefact, which SPDX's own reader accepts."""
    assert validate_full_spdx_document(parse_from_file(f"{artefact}.spdx.json")) == []
    document = json.loads(Path(f"{artefact}.spdx.json").read_text(encoding="utf-8"))
    ours, *others = document["packages"]
    assert document["spdxVersion"] == "SPDX-2.3"
    assert ours["checksums"][0]["checksumValue"] == digest(artefact)
    return {part["name"]: part["versionInfo"] for part in others}


def check(folder: Path) -> subprocess.CompletedProcess[str]:
    words = ["sha256sum", "--check", "--quiet", "SHA256SUMS"]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, check=False)


def test_packed_again_under_another_umask_the_bytes_are_the_same(package: Path, arch: str) -> None:
    first = digest(package)
    before = os.umask(0o077)
    try:
        again = build(arch)
    finally:
        os.umask(before)
    assert again == package and digest(again) == first


def test_the_list_names_the_libraries_that_the_program_loads(package: Path, tmp_path: Path) -> None:
    run(["dpkg-deb", "--extract", str(package), str(tmp_path)])
    loaded = re.findall(
        r"^\s*(?:/\S*/)?(lib\S+|ld-\S+)", run(["ldd", f"{tmp_path}/usr/bin/flotillad"]), re.M
    )
    listed = parts(package)
    assert loaded and set(loaded) <= set(listed)
    assert {"libeigen3-dev", "libcli11-dev", "nlohmann-json3-dev", "libtomlplusplus-dev"} <= set(
        listed
    )
    assert {"libgcc", "libstdc++", "libc6"} <= {
        re.sub(r"(-\d+)?-dev$", "", name) for name in listed
    }
    assert "NOASSERTION" not in listed.values()
    pins = (SOURCES / "tools" / "requirements.txt").read_text(encoding="utf-8")
    assert f"\npymavlink=={listed['pymavlink']} " in pins


def test_a_changed_byte_is_found_and_named(package: Path, tmp_path: Path) -> None:
    folder = tmp_path / "packages"
    shutil.copytree(package.parent, folder)
    assert check(folder).returncode == 0
    data = bytearray((folder / package.name).read_bytes())
    data[len(data) // 2] ^= 1
    (folder / package.name).write_bytes(data)
    done = check(folder)
    assert done.returncode == 1 and f"{package.name}: FAILED" in done.stdout


def test_the_release_has_every_kind_of_package() -> None:
    script = (SOURCES / "tools" / "package").read_text(encoding="utf-8")
    (kinds,) = re.findall(r"unknown kind \$kind; choose (.*)\"", script)
    workflow = (SOURCES / ".github/workflows/release.yml").read_text(encoding="utf-8")
    released = " ".join(re.findall("run: tools/package (.*)", workflow))
    assert set(released.split()) == set(re.split(", | or ", kinds))


@pytest.mark.nightly
def test_a_clone_elsewhere_gives_the_same_bytes(
    package: Path, image: Path, arch: str, tmp_path: Path
) -> None:
    """Compiled anew, without the compiler's cache."""
    clone = tmp_path / "another" / "clone"
    script = f"""umask 077; git clone -q {SOURCES} {clone}; cd {clone}
        CCACHE_DISABLE=1 tools/package {arch} oci-{arch}"""
    done = subprocess.run(["bash", "-ec", script], check=True, stdout=subprocess.PIPE, text=True)
    theirs = [digest(clone / path) for path in done.stdout.split()]
    assert theirs == [digest(package), digest(image)]
