# SPDX-License-Identifier: MIT
"""Makes a container image, which is also a BlueOS extension, from Debian packages.

python tools/oci.py IMAGE.tar ARCH PACKAGE.deb…; tools/package calls it. The tar is an OCI layout
and, by its manifest.json, an archive for `docker load`. Nothing in it is compressed, so that its
bytes do not depend on the version of a compressor.
"""

import hashlib
import io
import json
import os
import re
import subprocess
import sys
import tarfile
from datetime import UTC, datetime
from pathlib import Path

ROOT = Path(__file__).parents[1]
#: Port of the page on the host's network; free on BlueOS.
PORT = 9851
#: OCI's platform for each Debian architecture.
PLATFORMS = {
    "amd64": {"architecture": "amd64", "os": "linux"},
    "arm64": {"architecture": "arm64", "os": "linux", "variant": "v8"},
    "armhf": {"architecture": "arm", "os": "linux", "variant": "v7"},
}
#: Files of the packages that the image takes: programs, libraries, licences, the configuration.
KEEP = re.compile(
    r"bin/busybox|usr/bin/flotillad|(usr/)?lib\d*/([^/]+/)?[^/]+\.so[.\d]*"
    r"|usr/share/doc/[^/]+(/copyright)?|etc/flotilla/boat\.toml"
)
#: The user id of flotillad; 20 is Debian's group dialout, which owns serial ports.
USER = 999
ACCOUNTS = {
    "etc/passwd": f"root:x:0:0::/:/bin/false\nflotilla:x:{USER}:{USER}::/:/bin/false\n",
    "etc/group": f"root:x:0:\ndialout:x:20:flotilla\nflotilla:x:{USER}:\n",
}
EMAIL = "flotilla@users.noreply.github.com"
ABOUT = "autopilot of twin-propeller boats that sail in formation"
#: BlueOS's request to Docker: the host's network, for CAN and MAVLink, and serial ports.
PERMISSIONS = {
    "ExposedPorts": {f"{PORT}/tcp": {}},
    "HostConfig": {
        "NetworkMode": "host",
        "Binds": [
            "/usr/blueos/extensions/flotilla/config:/etc/flotilla",
            "/usr/blueos/extensions/flotilla/state:/var/lib/flotilla",
            "/usr/blueos/extensions/flotilla/log:/var/log/flotilla",
            "/dev:/dev",
        ],
        # ttyS, ttyACM, ttyUSB, ttyAMA
        "DeviceCgroupRules": ["c 4:* rw", "c 166:* rw", "c 188:* rw", "c 204:* rw"],
        # as in flotillad.service
        "Ulimits": [
            {"Name": "rtprio", "Soft": 50, "Hard": 50},
            {"Name": "memlock", "Soft": -1, "Hard": -1},
        ],
        "RestartPolicy": {"Name": "unless-stopped"},
    },
}


def plain(value: object) -> bytes:
    """JSON with equal bytes for equal values."""
    return json.dumps(value, sort_keys=True).encode()


def semver(version: str) -> str:
    """A valid image tag: 0.1+20261121020214.619cf70a becomes 0.1.0-20261121020214-619cf70a."""
    base, _, commit = version.partition("+")
    return f"{base}.0" + (f"-{re.sub('[.+]', '-', commit)}" if commit else "")


def labels(version: str) -> dict[str, str]:
    """Labels for BlueOS. Flotilla has no web address yet, hence no readme and no links."""
    texts: dict[str, object] = {
        "permissions": PERMISSIONS,
        "authors": [{"name": "The Flotilla developers", "email": EMAIL}],
        "company": {"name": "Flotilla", "about": ABOUT, "email": EMAIL},
        "links": {},
        "tags": ["autopilot", "formation", "dronecan", "mavlink", "boat"],
    }
    words = {"version": version, "readme": "", "type": "other", "requirements": "core >= 1.1"}
    return words | {name: plain(value).decode() for name, value in texts.items()}


def service(version: str) -> dict[str, str]:
    """The answer to BlueOS's request /register_service, by which BlueOS finds the page."""
    return {
        "name": "Flotilla",
        "description": ABOUT,
        "icon": "mdi-sail-boat",
        "company": "Flotilla",
        "version": version,
        "webpage": "",
        "api": "",
    }


class Tree:
    """A tar of files that belong to root, sorted, all with the same date."""

    def __init__(self, date: int) -> None:
        self._date = date
        self._found: dict[str, tuple[tarfile.TarInfo, bytes]] = {}

    def put(self, name: str, data: bytes = b"", mode: int = 0o644, link: str = "") -> None:
        """Add a file or, with `link`, a symbolic link; and the folders above it."""
        self.folder(str(Path(name).parent))
        self._add(name, mode, tarfile.SYMTYPE if link else tarfile.REGTYPE, data, link)

    def folder(self, name: str) -> None:
        """Add a folder and those above it."""
        for each in (Path(name), *Path(name).parents):
            if each.name:
                self._add(str(each), 0o755, tarfile.DIRTYPE)

    def _add(self, name: str, mode: int, kind: bytes, data: bytes = b"", link: str = "") -> None:
        info = tarfile.TarInfo(name)
        info.mode, info.type, info.linkname = mode, kind, link
        info.size, info.mtime = len(data), self._date
        self._found[name] = (info, data)

    def tar(self) -> bytes:
        """The tar's bytes."""
        memory = io.BytesIO()
        with tarfile.open(fileobj=memory, mode="w", format=tarfile.USTAR_FORMAT) as archive:
            for _, (info, data) in sorted(self._found.items()):
                archive.addfile(info, io.BytesIO(data))
        return memory.getvalue()


def dpkg_deb(*words: str) -> bytes:
    """Output of dpkg-deb."""
    return subprocess.run(["dpkg-deb", *words], check=True, stdout=subprocess.PIPE).stdout  # noqa: S603, S607


def unpack(package: Path, tree: Tree) -> None:
    """Put the package's files that the image keeps into the tree, and a record of the package."""
    with tarfile.open(fileobj=io.BytesIO(dpkg_deb("--fsys-tarfile", str(package)))) as archive:
        for member in archive:
            name = member.name.removeprefix("./")
            if member.isdir() or not KEEP.fullmatch(name):
                continue
            file = archive.extractfile(member) if member.isreg() else None
            target = name.replace("etc/flotilla/", "usr/share/flotilla/")
            tree.put(target, file.read() if file else b"", member.mode, member.linkname)
    # the place where image scanners look for it
    control = dpkg_deb("--field", str(package))
    name = dpkg_deb("--field", str(package), "Package").decode().strip()
    tree.put(f"var/lib/dpkg/status.d/{name}", control)


def layer(packages: list[Path], version: str, date: int) -> bytes:
    """The image's only layer."""
    tree = Tree(date)
    for package in packages:
        unpack(package, tree)
    for name, text in ACCOUNTS.items():
        tree.put(name, text.encode())
    for name in ("etc/flotilla", "run", "var/lib/flotilla", "var/log/flotilla"):
        tree.folder(name)
    extension = ROOT / "firmware" / "linux" / "extension"
    for file in (each for each in extension.rglob("*") if each.is_file()):
        script = file.read_bytes().startswith(b"#!")
        place = f"usr/share/flotilla/{file.relative_to(extension)}"
        tree.put(place, file.read_bytes(), 0o755 if script else 0o644)
    page = "usr/share/flotilla/page"
    tree.put(f"{page}/register_service", plain(service(version)))
    tree.put(f"{page}/messages", link="/run/messages")
    return tree.tar()


def write(image: Path, arch: str, packages: list[Path]) -> None:
    """Make the image from flotillad's package and the packages that it needs."""
    date = int(os.environ["SOURCE_DATE_EPOCH"])
    (own,) = (package for package in packages if package.name.startswith("flotillad_"))
    version = semver(dpkg_deb("--field", str(own), "Version").decode().strip())
    blobs = Tree(date)

    def blob(data: bytes) -> dict[str, object]:
        digest = hashlib.sha256(data).hexdigest()
        blobs.put(f"blobs/sha256/{digest}", data)
        return {"digest": f"sha256:{digest}", "size": len(data)}

    files = layer(packages, version, date)
    content = blob(files)
    created = datetime.fromtimestamp(date, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    settings = {
        **PLATFORMS[arch],
        "created": created,
        "config": {
            "Entrypoint": ["/usr/share/flotilla/start"],
            "ExposedPorts": PERMISSIONS["ExposedPorts"],
            "Labels": labels(version),
        },
        "rootfs": {"type": "layers", "diff_ids": [content["digest"]]},
        "history": [{"created": created, "created_by": "tools/oci.py"}],
    }
    oci = "application/vnd.oci.image"
    config = blob(plain(settings))
    manifest = {
        "schemaVersion": 2,
        "mediaType": f"{oci}.manifest.v1+json",
        "config": {"mediaType": f"{oci}.config.v1+json", **config},
        "layers": [{"mediaType": f"{oci}.layer.v1.tar", **content}],
    }
    entry = {
        "mediaType": f"{oci}.manifest.v1+json",
        **blob(plain(manifest)),
        "platform": PLATFORMS[arch],
        "annotations": {
            "org.opencontainers.image.ref.name": version,
            "io.containerd.image.name": f"docker.io/library/flotilla:{version}",
        },
    }
    blobs.put("oci-layout", plain({"imageLayoutVersion": "1.0.0"}))
    blobs.put("index.json", plain({"schemaVersion": 2, "manifests": [entry]}))
    # for `docker load` before Docker 25, which does not know OCI layouts
    paths = [f"blobs/{str(each['digest']).replace(':', '/')}" for each in (config, content)]
    docker = {"Config": paths[0], "RepoTags": [f"flotilla:{version}"], "Layers": paths[1:]}
    blobs.put("manifest.json", plain([docker]))
    image.write_bytes(blobs.tar())


if __name__ == "__main__":
    write(Path(sys.argv[1]), sys.argv[2], [Path(word) for word in sys.argv[3:]])
