# SPDX-License-Identifier: MIT
"""Writes ARTEFACT.spdx.json, SPDX 2.3: the packages linked into an artefact or bundled with it.

python tools/sbom.py KIND ARTEFACT; tools/package calls it.
"""

import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile
import zipfile
from datetime import UTC, datetime
from pathlib import Path

#: Debian's packages whose headers are compiled in, by kind of artefact.
HEADERS = {
    "image": [
        "libeigen3-dev",
        "gcc-arm-none-eabi",
        "libnewlib-arm-none-eabi",
        "libstdc++-arm-none-eabi-newlib",
    ],
    "deb": ["libeigen3-dev", "libcli11-dev", "nlohmann-json3-dev", "libtomlplusplus-dev"],
}
HEADERS["wheel"] = HEADERS["oci"] = HEADERS["deb"]
#: Debian's folder for an architecture's libraries; a wheel is for this machine.
TRIPLETS = {
    "amd64": "x86_64-linux-gnu",
    "arm64": "aarch64-linux-gnu",
    "armhf": "arm-linux-gnueabihf",
    "wheel": f"{os.uname().machine}-linux-gnu",
}
#: The compilers for other processors.
COMPILERS = {"arm64": "aarch64-linux-gnu-g++", "armhf": "arm-linux-gnueabihf-g++"}
#: Files that identify packages of which a part is in every program, and that part.
LINKED = {
    "libgcc.a": "linked in: functions that the compiler calls",
    "crt1.o": "linked in: the start of a program",
    "libstdc++.a": "compiled in: templates of its headers",
}


def output(*words: str) -> str:
    """Output of a program; empty if it fails or is missing."""
    try:
        done = subprocess.run(words, check=False, capture_output=True, text=True)  # noqa: S603
    except FileNotFoundError:
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""


def debian_version(package: str) -> str:
    """The version of a package installed on this computer."""
    return output("dpkg-query", "--show", "--showformat=${Version}", package) or "NOASSERTION"


def locked(name: str) -> str:
    """The version that tools/requirements.txt pins."""
    pins = Path(__file__).with_name("requirements.txt").read_text(encoding="utf-8")
    found = re.search(rf"^{re.escape(name)}==([^ \\]+)", pins, re.MULTILINE | re.IGNORECASE)
    return found[1] if found else "NOASSERTION"


def shared_libraries(folder: Path) -> set[str]:
    """The libraries that the programs and modules of a folder name as NEEDED."""
    needed = set()
    for file in folder.rglob("*"):
        if file.is_file() and file.open("rb").read(4) == b"\x7fELF":
            needed |= set(re.findall(r"NEEDED.*\[(.*)\]", output("readelf", "-d", str(file))))
    return needed


def owner(library: str, triplet: str) -> tuple[str, str]:
    """Version and comment of a shared library, from the Debian package that owns it here."""
    found = [
        output("dpkg-query", "--search", f"*/{triplet}/{folder}{library}")
        for folder in ("", "lib/")
    ]
    for line in "\n".join(filter(None, found)).splitlines():
        package = line.split(": ")[0].split(",")[0]
        return debian_version(package), f"shared library of Debian's {package}"
    return "NOASSERTION", "shared library"


def linked(arch: str) -> dict[str, tuple[str, str]]:
    """Version and way of use of the packages that the compiler links into a program."""
    found = {}
    for name, use in LINKED.items():
        path = output(COMPILERS.get(arch, "g++"), f"-print-file-name={name}")
        package = output("dpkg-query", "--search", os.path.realpath(path)).split(":")[0]
        found[package or name] = (debian_version(package), use)
    return found


def bundled(image: Path, place: Path) -> dict[str, tuple[str, str]]:
    """Version and way of use of the Debian packages in a container's image."""
    output("tar", "--extract", f"--file={image}", f"--directory={place}")
    (docker,) = json.loads((place / "manifest.json").read_bytes())
    output("tar", "--extract", f"--file={place / docker['Layers'][0]}", f"--directory={place}")
    found = {}
    for control in (place / "var/lib/dpkg/status.d").iterdir():
        fields = dict(re.findall("^(Package|Version): (.*)$", control.read_text(), re.MULTILINE))
        found[fields["Package"]] = (fields["Version"], "bundled: Debian's package")
    return found


def contents(kind: str, artefact: Path) -> dict[str, tuple[str, str]]:
    """Version and way of use of an artefact's packages, by name."""
    sort = "deb" if kind in TRIPLETS and kind != "wheel" else kind.partition("-")[0]
    found = {name: (debian_version(name), "compiled in") for name in HEADERS[sort]}
    found["pymavlink"] = (locked("pymavlink"), "its dialect and SHA-256, compiled in")
    with tempfile.TemporaryDirectory() as place:
        if sort == "deb":
            output("dpkg-deb", "--extract", str(artefact), place)
        elif sort == "oci":
            found |= bundled(artefact, Path(place))
        elif sort == "wheel":
            with zipfile.ZipFile(artefact) as archive:
                archive.extractall(place)
                metadata = next(n for n in archive.namelist() if n.endswith("/METADATA"))
                text = archive.read(metadata).decode()
            found["libjs-chart.js"] = (debian_version("libjs-chart.js"), "bundled: chart.min.js")
            found["nanobind"] = (locked("nanobind"), "compiled in")
            for name in re.findall(r"^Requires-Dist: ([\w.-]+)\s*$", text, re.MULTILINE):
                use = "compiled in and required" if name in found else "required"
                found[name] = (locked(name), use)
        if sort != "image":
            found |= linked(kind.removeprefix("oci-"))
        if kind in TRIPLETS:
            libraries = shared_libraries(Path(place))
            found |= {name: owner(name, TRIPLETS[kind]) for name in libraries}
    return found


def main(kind: str, artefact: Path) -> None:
    """Write the list next to the artefact."""
    digest = hashlib.sha256(artefact.read_bytes()).hexdigest()
    date = datetime.fromtimestamp(int(os.environ["SOURCE_DATE_EPOCH"]), UTC)
    packages = [
        {
            "SPDXID": "SPDXRef-artefact",
            "name": artefact.name,
            "downloadLocation": "NOASSERTION",
            "filesAnalyzed": False,
            "checksums": [{"algorithm": "SHA256", "checksumValue": digest}],
        }
    ]
    relations = [("SPDXRef-DOCUMENT", "DESCRIBES", "SPDXRef-artefact")]
    for number, (name, (version, use)) in enumerate(sorted(contents(kind, artefact).items())):
        spdx_id = f"SPDXRef-part-{number}"
        packages.append(
            {
                "SPDXID": spdx_id,
                "name": name,
                "versionInfo": version,
                "downloadLocation": "NOASSERTION",
                "filesAnalyzed": False,
                "comment": use,
            }
        )
        relations.append(("SPDXRef-artefact", "DEPENDS_ON", spdx_id))
    document = {
        "spdxVersion": "SPDX-2.3",
        "dataLicense": "CC0-1.0",
        "SPDXID": "SPDXRef-DOCUMENT",
        "name": artefact.name,
        "documentNamespace": f"https://flotilla.invalid/spdx/{digest}",
        "creationInfo": {
            "created": date.strftime("%Y-%m-%dT%H:%M:%SZ"),
            "creators": ["Tool: flotilla-sbom"],
        },
        "packages": packages,
        "relationships": [
            {"spdxElementId": one, "relationshipType": kind_of, "relatedSpdxElement": other}
            for one, kind_of, other in relations
        ],
    }
    Path(f"{artefact}.spdx.json").write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main(sys.argv[1], Path(sys.argv[2]))
