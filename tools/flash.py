# SPDX-License-Identifier: MIT
"""Installs flotillad on a boat by ssh: `tools/flash`.

The boat keeps the new package only if it then answers over MAVLink with the version that was sent,
on a link of its configuration that local programs can reach (`udpin:`). The boat needs nothing but
Debian: its bash relays bytes between the ssh connection and the link.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import re
import select
import shlex
import subprocess
import sys
import tempfile
import time
import tomllib
from pathlib import Path
from typing import NamedTuple

from pymavlink.dialects.v20 import common as mavlink

SOURCES = Path(__file__).parents[1]
CONFIG = "/etc/flotilla/boat.toml"
PATIENCE_S = 30.0
ASK_EVERY_S = 0.5
ME = (255, mavlink.MAV_COMP_ID_ONBOARD_COMPUTER)


class TroubleError(Exception):
    """Stops the installation; the text is for the operator."""


class Answer(NamedTuple):
    """A boat's answer by MAVLink."""

    armed: bool
    revision: str  #: eight characters, empty if the boat sent none


class Link(NamedTuple):
    """A UDP port of the boat, seen from the boat; `signed`: it accepts signed messages only."""

    host: str
    port: int
    signed: bool


class Boat:
    """The boat's shell. Connections share one login, for which ssh may ask a password."""

    def __init__(self, host: str, folder: Path) -> None:
        self.host = host
        shared = [f"ControlPath={folder}/%C", "ControlMaster=auto", "ControlPersist=60"]
        watched = ["ServerAliveInterval=5", "ConnectTimeout=10"]
        self._options = [word for option in shared + watched for word in ("-o", option)]
        self._sudo = [] if self.say("id", "-u") == "0" else ["sudo", "-n"]

    def words(self, *command: str) -> list[str]:
        """The local command line that runs a command on the boat."""
        return ["ssh", *self._options, self.host, shlex.join(command)]

    def say(self, *command: str) -> str:
        """The output of a command on the boat; TroubleError if it fails."""
        done = subprocess.run(
            self.words(*command),
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            check=False,
        )
        if done.returncode:
            raise TroubleError(f"{self.host}: {shlex.join(command)}: {done.stderr.strip()}")
        return done.stdout.strip()

    def copy(self, *files: tuple[Path, str]) -> None:
        """Copy local files to paths on the boat; TroubleError if that fails."""
        for file, target in files:
            words = ["scp", "-q", *self._options, str(file), f"{self.host}:{target}"]
            if subprocess.run(words, check=False).returncode:
                raise TroubleError(f"{self.host}: {file.name} could not be copied")

    def install(self, folder: str) -> subprocess.Popen[str]:
        """Start tools/flash-install on the boat; it installs, then waits for our verdict."""
        words = self.words(*self._sudo, "bash", f"{folder}/flash-install", folder)
        return subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def link(self) -> Link | None:
        """The first link of its configuration that programs on the boat can reach."""
        config = tomllib.loads(self.say("cat", CONFIG))
        links, secret = config.get("mavlink", []), bool(config.get("signing-key"))
        for text in links if isinstance(links, list) else [links]:
            found = re.match(r"udpin:(?:([0-9.]+):)?([0-9]+)(.*)", text)
            if found and not (found[1] or "").endswith(".255"):
                host = "127.0.0.1" if found[1] in (None, "0.0.0.0") else found[1]
                policy = re.search("signing=([a-z]+)", found[3])
                required = policy[1] == "required" if policy else secret
                return Link(host, int(found[2]), required)
        return None

    def ask(self, link: Link, seconds: float) -> Answer | None:
        """Ask the boat on `link` for its state and version; None: no answer within `seconds`."""
        there = f"/dev/udp/{link.host}/{link.port}"
        # The end of either direction ends both: a port not open yet closes the connection.
        relay = f"exec 3<>{there} 4<&0; cat <&3 & cat <&4 >&3 & wait -n; kill $(jobs -p)"
        until = time.monotonic() + seconds
        answer = None
        while time.monotonic() < until and (answer is None or not (answer.revision or link.signed)):
            with subprocess.Popen(
                self.words("bash", "-c", relay),
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=subprocess.DEVNULL,
                bufsize=0,
            ) as line:
                with contextlib.suppress(BrokenPipeError):
                    answer = converse(line, until) or answer
                line.kill()
        return answer


def converse(line: subprocess.Popen[bytes], until: float) -> Answer | None:
    """Read the boat's answer, as far as complete when the line closes or the time is up."""
    assert line.stdin is not None
    assert line.stdout is not None
    codec = mavlink.MAVLink(None, *ME)
    codec.robust_parsing = True
    beat = mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, 0, 3
    )
    who, armed = (0, 0), None
    while (now := time.monotonic()) < until:
        question = mavlink.MAVLink_command_long_message(
            *who, mavlink.MAV_CMD_REQUEST_MESSAGE, 0, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION,
            0, 0, 0, 0, 0, 0,
        )  # fmt: skip
        line.stdin.write(beat.pack(codec) + (question.pack(codec) if who[0] else b""))
        while (left := min(now + ASK_EVERY_S, until) - time.monotonic()) > 0:
            if not select.select([line.stdout], [], [], left)[0]:
                break
            data = os.read(line.stdout.fileno(), 4096)
            if not data:
                time.sleep(ASK_EVERY_S)
                return None if armed is None else Answer(armed, "")
            for message in codec.parse_buffer(data) or []:
                if message.get_type() == "HEARTBEAT":
                    who = (message.get_srcSystem(), message.get_srcComponent())
                    armed = bool(message.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED)
                elif message.get_type() == "AUTOPILOT_VERSION" and armed is not None:
                    revision = bytes(message.flight_custom_version).decode("ascii", "replace")
                    return Answer(armed, revision.rstrip("\0"))
    return None if armed is None else Answer(armed, "")


def version_of(package: Path) -> tuple[str, str]:
    """The expected output of `flotillad --version`, and the commit in it."""
    words = ["dpkg-deb", "--field", str(package), "Version"]
    text = subprocess.run(words, capture_output=True, text=True, check=False).stdout.strip()
    found = re.match(r"([0-9.]+)\+[0-9]+\.([0-9a-f]{8})", text)
    if not found:
        raise TroubleError(f"{package}: not a package made by tools/package")
    return f"flotillad {found[1]} ({found[2]})", found[2]


def judge(boat: Boat, said: str, package: Path) -> str | None:
    """The reason why the boat must not keep the new package; None: it may."""
    version, revision = version_of(package)
    if said != f"installed: {version}":
        return f"expected {version}, but the boat reports: {said or 'nothing'}"
    link = boat.link()
    if link is None:
        return f"{CONFIG} has no udpin link that programs on the boat can reach: add one"
    print(f"waiting for the boat at udp {link.host}:{link.port} of {boat.host} ...", flush=True)
    answer = boat.ask(link, PATIENCE_S)
    if answer is None:
        return f"no HEARTBEAT within {PATIENCE_S:.0f} s"
    if answer.revision != revision and not (link.signed and not answer.revision):
        return f"the boat answers with version {answer.revision or 'unknown'}, not {revision}"
    return None


def refuse_armed(boat: Boat) -> None:
    """Exit if the boat is armed: its propellers may turn."""
    with contextlib.suppress(TroubleError):  # before the first installation: no configuration
        link = boat.link()
        answer = boat.ask(link, 3.0) if link else None
        if answer is None or not answer.armed:
            return
        sys.exit(f"flash: {boat.host}: the boat is armed: disarm it first")


def flash(boat: Boat, package: Path) -> None:
    """Install `package`; TroubleError if the boat refused it or rolled back."""
    refuse_armed(boat)
    folder = boat.say("mktemp", "--directory")
    install = SOURCES / "tools" / "flash-install"
    boat.copy((package, f"{folder}/flotillad.deb"), (install, f"{folder}/flash-install"))
    print(f"installing {package.name} on {boat.host} ...", flush=True)
    installer = boat.install(folder)
    assert installer.stdin is not None
    assert installer.stdout is not None
    said = installer.stdout.readline().strip()
    if said.startswith("refused"):
        raise TroubleError(f"{boat.host}: {said}")
    why = said if said.startswith("failed") else None
    try:
        why = why or judge(boat, said, package)
    except TroubleError as trouble:
        why = str(trouble)
    with contextlib.suppress(BrokenPipeError):
        installer.stdin.write("back\n" if why else "keep\n")
        installer.stdin.close()
    end = installer.stdout.read().strip()
    installer.wait()
    if why:
        raise TroubleError(
            f"{boat.host}: {why}; {end or 'connection lost: the boat rolls back by itself'}"
        )
    if end != "kept":
        raise TroubleError(f"{boat.host}: connection lost: the boat rolls back by itself")


def main() -> None:
    """Parse the command line, build the package if none is given, install it."""
    parser = argparse.ArgumentParser(prog="tools/flash", description=__doc__)
    parser.add_argument("HOST", help="ssh destination: root, or a user with passwordless sudo")
    parser.add_argument("PACKAGE", nargs="?", type=Path, help="install this .deb, not this tree's")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="flash-") as folder:
        try:
            boat = Boat(arguments.HOST, Path(folder))
            package = arguments.PACKAGE
            if package is None:
                words = [
                    str(SOURCES / "tools" / "package"),
                    boat.say("dpkg", "--print-architecture"),
                ]
                built = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True).stdout
                package = SOURCES / built.strip()
            flash(boat, package)
        except TroubleError as trouble:
            sys.exit(f"flash: {trouble}")
        print(f"{arguments.HOST} answers as {version_of(package)[0]}")


if __name__ == "__main__":
    main()
