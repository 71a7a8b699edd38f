# SPDX-License-Identifier: MIT
"""The service, its user, its folders, and the files that it needs."""

import os
from collections.abc import Iterator

from sil.doctor.boat_file import Boat, is_whole
from sil.doctor.computer import READ, WRITE, Computer
from sil.doctor.finding import Finding, bad, doubt, ok

_UNITS = ("/lib/systemd/system", "/usr/lib/systemd/system", "/etc/systemd/system")
_NAME = "flotillad.service"
_ETC = f"/etc/systemd/system/{_NAME}"
_ENABLED = f"/etc/systemd/system/multi-user.target.wants/{_NAME}"
_KEY_BYTES, _KEY_DIGITS = 32, 64
_OTHERS = 0o077


def service(computer: Computer) -> Iterator[Finding]:
    """Whether the service is installed, has its user, and starts with the computer."""
    etc = computer.at(_ETC)
    if etc.is_symlink() and os.readlink(etc) == "/dev/null":
        yield bad(_NAME, "is masked: it cannot start", f"sudo systemctl unmask {_NAME}")
    elif not any(computer.at(f"{folder}/{_NAME}").exists() for folder in _UNITS):
        yield bad(_NAME, "is not installed", "install the Debian package: tools/flash")
    elif not computer.at(_ENABLED).is_symlink():
        remedy = f"sudo systemctl enable --now {_NAME}"
        yield bad(_NAME, "does not start with the computer", remedy)
    else:
        yield ok(_NAME, "starts with the computer")
    if not computer.has_user:
        remedy = "sudo systemd-sysusers flotillad.conf, or reinstall the Debian package"
        yield bad("user", f"there is no user {computer.user}", remedy)


def groups(computer: Computer, boat: Boat) -> Iterator[Finding]:
    """Whether the user may use devices that belong to a group."""
    wanted = {"dialout": any(link.scheme == "serial" for link in boat.links)}
    wanted["gpio"] = bool(boat.stop_gpio)
    for name, needed in wanted.items():
        if computer.has_user and needed and name not in computer.groups:
            yield bad(
                "user",
                f"{computer.user} is not in the group {name}",
                f"sudo usermod -aG {name} {computer.user} && sudo systemctl restart flotillad",
            )


def folders(computer: Computer, boat: Boat) -> Iterator[Finding]:
    """Whether the boat can keep its parameters and logs."""
    for path, meaning in ((boat.state_dir, "parameters are saved"), (boat.log, "logs are written")):
        if not path:
            yield doubt(
                "log",
                "no logs are written",
                'set log = "/var/log/flotilla" in the configuration file',
            )
            continue
        remedy = f"sudo install -d -o {computer.user} -g {computer.user} -m 750 {path}"
        try:
            writable = computer.may(path, READ | WRITE | 1)
        except OSError:
            yield bad(path, f"does not exist, but {meaning} there", remedy)
            continue
        if not computer.at(path).is_dir():
            yield bad(path, "is not a folder", f"move it away, then {remedy}")
        elif writable:
            yield ok(path, f"{meaning} there")
        else:
            yield bad(path, f"{computer.user} may not write there", remedy)


def parameters(computer: Computer, boat: Boat) -> Iterator[Finding]:
    """Whether the boat has saved parameters of its own."""
    path = boat.parameter_file
    confirm = (
        "set the boat's parameters in the ground station and save them (MAV_CMD_PREFLIGHT_STORAGE)"
    )
    text = computer.read(path)
    if text is None and computer.is_hidden(path):
        yield doubt(path, "permission denied", "start the doctor with sudo")
    elif text is None:
        yield bad(path, "parameters were never saved: the boat does not arm", confirm)
    elif not is_whole(text):
        earlier = computer.read(f"{path}.previous")
        if earlier is not None and is_whole(earlier):
            yield doubt(
                path, "is damaged; the boat uses the previous version", f"check them, {confirm}"
            )
        else:
            yield bad(path, "is damaged: the boat does not arm", confirm)
    else:
        yield ok(path, "is intact")


def signing_key(computer: Computer, boat: Boat) -> Iterator[Finding]:
    """Whether the key exists, is valid, and is readable by its owner only."""
    path = boat.signing_key
    if not path:
        what = "there is no key: anybody in range can command the boat"
        remedy = "set signing-key in the configuration file: firmware/docs/MAVLINK.md"
        yield doubt("signing", what, remedy)
        return
    own = f"sudo chown {computer.user} {path} && sudo chmod 600 {path}"
    try:
        status = computer.at(path).stat()
        mode, readable = status.st_mode, computer.may(path, READ)
    except PermissionError:
        yield doubt(path, "permission denied", "start the doctor with sudo")
        return
    except OSError:
        make = f"head -c 32 /dev/urandom | sudo tee {path} >/dev/null && {own}"
        yield bad(path, "there is no such signing key", f"copy the fleet's key there, or {make}")
        return
    if mode & _OTHERS:
        yield bad(path, "others may read the signing key: flotillad refuses it", own)
    elif not readable:
        yield bad(path, f"{computer.user} may not read the signing key", own)
    elif status.st_size not in (_KEY_BYTES, _KEY_DIGITS, _KEY_DIGITS + 1):
        what = f"has {status.st_size} bytes; a key has 32, or 64 hexadecimal digits"
        yield bad(path, what, "copy the fleet's key there again, whole")
    else:
        yield ok(path, "is secret")
