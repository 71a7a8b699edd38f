# SPDX-License-Identifier: MIT
"""The boat's configuration file and its saved parameters, as far as the doctor needs them.

flotillad itself checks the file (`flotillad --check`); the doctor reads only the places to examine.
"""

import subprocess
import tomllib
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import flotilla

from sil.doctor.computer import Computer
from sil.doctor.finding import Finding, bad, ok
from sil.live.live_world import FLOTILLAD
from sil.live.ordinary_user import ordinary_user

_PROGRAM = "/usr/bin/flotillad"
_EDIT = "correct it, then: sudo systemctl restart flotillad; `flotillad --help` has every key"
_CRC = "crc32 = "


@dataclass(frozen=True)
class Link:
    """A MAVLink link: `address` as in the file, without its options."""

    address: str
    signing: str = "off"

    @property
    def scheme(self) -> str:
        """udpin, udpout, udpbcast or serial."""
        return self.address.partition(":")[0]

    @property
    def rest(self) -> str:
        """The address without the scheme."""
        return self.address.partition(":")[2]


@dataclass(frozen=True)
class Boat:
    """A boat from its file; `parameters`: defaults, then the saved ones, then the file's."""

    can: str = "socketcan:can0"
    links: tuple[Link, ...] = ()
    state_dir: str = "/var/lib/flotilla"
    log: str = ""
    signing_key: str = ""
    stop_gpio: str = ""
    parameters: Mapping[str, float] = field(default_factory=dict)

    @property
    def parameter_file(self) -> str:
        """Path of the file with the operator's parameters."""
        return f"{self.state_dir}/parameters.txt"

    @property
    def system(self) -> int:
        """MAV_SYSID."""
        return round(self.parameters.get("MAV_SYSID", 1))


def read(computer: Computer, path: str) -> tuple[Boat | None, list[Finding]]:
    """The boat of the file, None if there is none; findings about the file."""
    file = computer.at(path)
    try:
        text = file.read_bytes()
    except FileNotFoundError:
        remedy = "install flotillad (tools/flash, or the Debian package), or name one with --config"
        return None, [bad(path, "there is no such configuration file", remedy)]
    except OSError as error:
        return None, [bad(path, (error.strerror or "").lower(), f"sudo chmod 644 {path}")]
    found = list(_judged(computer, path))
    try:
        return _boat(computer, tomllib.loads(text.decode())), found
    except (ValueError, TypeError, AttributeError, KeyError) as error:
        return None, found if any(f.remedy for f in found) else [bad(path, str(error), _EDIT)]


def _judged(computer: Computer, path: str) -> Iterator[Finding]:
    """Findings from flotillad's own check of the file."""
    program = computer.at(_PROGRAM) if computer.at(_PROGRAM).exists() else FLOTILLAD
    if not program.exists():
        yield bad(_PROGRAM, "flotillad is not installed", "install the Debian package: tools/flash")
        return
    file = str(computer.at(path))
    words = [*ordinary_user(), str(program), "--config", file, "--check"]
    try:
        done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=30)  # noqa: S603
    except (OSError, subprocess.TimeoutExpired) as error:
        yield bad(str(program), f"does not start: {error}", "reinstall it: tools/flash")
        return
    if done.returncode == 0:
        yield ok(path, "is valid")
        return
    said = done.stderr.strip().removeprefix("flotillad: ").replace(file, path)
    place, separator, what = said.partition(": ") if said.startswith(path) else (path, ": ", said)
    yield bad(place if separator else path, what or said, _EDIT)


def _boat(computer: Computer, table: dict[str, Any]) -> Boat:
    state_dir = str(table.get("state-dir", Boat.state_dir))
    key = str(table.get("signing-key", ""))
    links = [_link(str(text), "required" if key else "off") for text in table.get("mavlink", [])]
    parameters = {each["name"]: float(each["default"]) for each in flotilla.parameter_list()}
    parameters |= saved(computer.read(f"{state_dir}/parameters.txt") or "")
    parameters |= {name: float(value) for name, value in table.get("param", {}).items()}
    return Boat(
        str(table.get("can", Boat.can)),
        tuple(links),
        state_dir,
        str(table.get("log", "")),
        key,
        str(table.get("stop-gpio", "")),
        parameters,
    )


def _link(text: str, signing: str) -> Link:
    address, *options = text.split(",")
    for option in options:
        name, _, value = option.partition("=")
        if name == "signing":
            signing = value
    return Link(address, signing)


def saved(text: str) -> dict[str, float]:
    """The parameters in a file of flotillad's; none if it is damaged."""
    if not is_whole(text):
        return {}
    pairs = (line.split(" = ") for line in text.splitlines()[1:] if not line.startswith(_CRC))
    return {pair[0]: float(pair[1]) for pair in pairs if len(pair) == 2}


def is_whole(text: str) -> bool:
    """Whether the checksum at the end of a parameter file matches its text."""
    body, separator, told = text.rpartition(_CRC)
    return bool(separator) and told.strip() == f"{zlib.crc32(body.encode()):08X}"
