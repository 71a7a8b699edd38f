# SPDX-License-Identifier: MIT
"""The container's image: what BlueOS reads of it, and a boat that sails in it without Docker."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.package.conftest import build
from tests.package.container import START
from tests.package.root import NETWORK, SOURCES, as_root, need, run, understand
from tests.package.test_foreign import lenient_socket
from tests.package.test_release import digest, parts

LIMIT_MB = 50
BUNDLED = ("busybox-static", "flotillad", "libc6", "libgcc-s1", "libstdc++6")
#: An image's tag that is a version too: semver.org, without +.
SEMVER = r"\d+\.\d+\.\d+(-[0-9A-Za-z-]+)?"


def unpacked(image: Path, folder: Path) -> Path:
    """The image's files, by its manifest for Docker."""
    run(["tar", "-xf", str(image), "-C", str(folder)])
    (docker,) = json.loads((folder / "manifest.json").read_bytes())
    files = folder / "files"
    files.mkdir()
    run(["tar", "-xf", str(folder / docker["Layers"][0]), "-C", str(files)])
    return files


def settings(image: Path) -> dict[str, dict[str, str]]:
    """The image's `config`."""
    (docker,) = json.loads(run(["tar", "-xOf", str(image), "manifest.json"]))
    found = json.loads(run(["tar", "-xOf", str(image), docker["Config"]]))["config"]
    assert docker["RepoTags"] == [f"flotilla:{found['Labels']['version']}"]
    return found


def test_packed_again_under_another_umask_the_bytes_are_the_same(
    image: Path, arch: str, capsys: pytest.CaptureFixture[str]
) -> None:
    first = digest(image)
    before = os.umask(0o077)
    try:
        again = build(f"oci-{arch}")
    finally:
        os.umask(before)
    assert again == image and digest(again) == first
    size_mb = image.stat().st_size / 1e6
    with capsys.disabled():
        print(f"\n{image.name}: {size_mb:.1f} MB (limit {LIMIT_MB})")
    assert size_mb < LIMIT_MB


def test_the_image_has_every_library_that_its_programs_load(image: Path, tmp_path: Path) -> None:
    files = unpacked(image, tmp_path)
    there = {file.name for file in files.rglob("*.so*")}
    loaded = run(
        ["readelf", "-d", str(files / "usr/bin/flotillad"), *map(str, files.rglob("*.so.*"))]
    )
    needed = set(re.findall(r"NEEDED.*\[(.*)\]", loaded))
    assert "libstdc++.so.6" in needed and needed <= there
    listed = parts(image)
    assert set(BUNDLED) <= set(listed)
    assert "NOASSERTION" not in listed.values()
    for name in BUNDLED:
        assert (files / "usr/share/doc" / name / "copyright").exists(), name


def test_blueos_can_read_the_labels(image: Path) -> None:
    found = settings(image)
    labels = found["Labels"]
    wanted = "version permissions authors company readme links type tags requirements"
    assert set(labels) == set(wanted.split())
    assert re.fullmatch(SEMVER, labels["version"])
    for name in ("permissions", "authors", "company", "links", "tags"):
        json.loads(labels[name])
    host = json.loads(labels["permissions"])["HostConfig"]
    assert host["NetworkMode"] == "host" and "Privileged" not in host
    (port,) = (port.removesuffix("/tcp") for port in found["ExposedPorts"])
    assert f"httpd -p {port} " in (SOURCES / "firmware/linux/extension/start").read_text()


def test_blueos_store_gets_a_description_and_a_square_logo(image: Path) -> None:
    folder = SOURCES / "firmware/linux/extension"
    told = json.loads((folder / "metadata.json").read_text(encoding="utf-8"))
    assert told.keys() == {"name", "website", "docker", "description"}
    company = json.loads(settings(image)["Labels"]["company"])
    assert told["name"] == company["name"]
    assert told["description"].lower() == company["about"]
    header = (folder / "extension_logo.png").read_bytes()[:24]
    assert header[:8] == b"\x89PNG\r\n\x1a\n" and header[16:20] == header[20:24]


class Bundle:
    """The image, unpacked by umoci for runc."""

    def __init__(self, image: Path, folder: Path) -> None:
        need("skopeo", "umoci", "runc", "unshare", "nsenter", "ip")
        self.folder, self.path = folder, folder / "bundle"
        version = settings(image)["Labels"]["version"]
        layout = folder / "layout"
        run(["skopeo", "copy", f"oci-archive:{image}:{version}", f"oci:{layout}:{version}"])
        run([*as_root(), "umoci", "unpack", f"--image={layout}:{version}", str(self.path)])

    def words(self, *command: str) -> list[str]:
        """The command line of a command in a network of its own."""
        network = f'{NETWORK} && exec "$@"'
        return [*as_root(), "unshare", "--net", "bash", "-c", network, "network", *command]

    def sail(self, *environment: str) -> str:
        """Output of a boat that sails in the container, on loopback."""
        module = [sys.executable, "-m", "tests.package"]
        sail = f"{module[-1]}.sail", str(self.folder), START, str(self.folder / "state")
        container = f"{module[-1]}.container", str(self.path), *environment
        words = [*module[:-1], *sail, *module[:-1], *container]
        return run(self.words("env", f"--chdir={SOURCES}", *words))


@pytest.mark.nightly
@pytest.mark.parametrize("transport", ["oci-archive", "docker-archive"])
def test_skopeo_reads_the_image_by_both_of_its_manifests(image: Path, transport: str) -> None:
    need("skopeo")
    version = settings(image)["Labels"]["version"]
    name = f":{version}" if transport == "oci-archive" else f":flotilla:{version}"
    found = json.loads(run(["skopeo", "inspect", f"{transport}:{image}{name}"]))
    assert found["Labels"]["version"] == version and len(found["Layers"]) == 1


@pytest.mark.nightly
def test_a_boat_sails_in_the_container(image: Path, tmp_path: Path) -> None:
    said = Bundle(image, tmp_path).sail()
    assert "pushes: (" in said and "status 0" in said


@pytest.mark.nightly
def test_the_page_shows_flotillads_messages_and_blueos_finds_it(
    image: Path, tmp_path: Path
) -> None:
    bundle = Bundle(image, tmp_path)
    words = [sys.executable, "-m", "tests.package.container", str(bundle.path), START]
    with subprocess.Popen(
        bundle.words("env", f"--chdir={SOURCES}", *words, "--can=mcast:0"),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        text=True,
    ) as boat:
        try:
            next(line for line in boat.stdout if "flotillad: ready" in line)
            enter = [*as_root(), "nsenter", f"--target={boat.pid}", "--net"]
            page, service, messages = (
                run([*enter, "curl", "--silent", "--fail", f"http://127.0.0.1:9851/{name}"])
                for name in ("", "register_service", "messages")
            )
        finally:
            boat.terminate()
            status = boat.wait(timeout=20)
    assert "<title>Flotilla</title>" in page
    assert json.loads(service)["version"] == settings(image)["Labels"]["version"]
    assert "flotillad 0.1 (" in messages and "flotillad: ready: boat 1 on mcast:0" in messages
    assert status == 0
    assert (bundle.path / "rootfs/etc/flotilla/boat.toml").stat().st_uid == 999


@pytest.mark.nightly
def test_a_mistake_in_the_configuration_ends_the_container_and_is_in_its_log(
    image: Path, tmp_path: Path
) -> None:
    bundle = Bundle(image, tmp_path)
    config = bundle.path / "rootfs" / "etc" / "flotilla" / "boat.toml"
    write = "echo 'mavlnk = []' > \"$0\""
    run([*as_root(), "sh", "-c", write, str(config)])
    words = [sys.executable, "-m", "tests.package.container", str(bundle.path), START]
    done = subprocess.run(
        bundle.words("env", f"--chdir={SOURCES}", *words),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        text=True,
        check=False,
    )
    assert done.returncode == 2 and "mavlnk" in done.stdout, done


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("arch", "triplet"), [("arm64", "aarch64-linux-gnu"), ("armhf", "arm-linux-gnueabihf")]
)
def test_a_boat_of_another_processor_sails_in_the_container(
    arch: str, triplet: str, tmp_path: Path
) -> None:
    need(f"{triplet}-g++")
    understand(arch)
    bundle = Bundle(build(f"oci-{arch}"), tmp_path)
    library = lenient_socket(tmp_path, f"{triplet}-g++")
    run([*as_root(), "cp", str(library), str(bundle.path / "rootfs" / "run")])
    said = bundle.sail(f"LD_PRELOAD=/run/{library.name}")
    assert "pushes: (" in said and "status 0" in said
