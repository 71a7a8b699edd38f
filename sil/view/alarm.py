# SPDX-License-Identifier: MIT
"""Alarms for a source that delivers nothing: the problem and its remedy."""

import errno
import socket

SILENT_S = (3, 10, 30, 60, 300, 1800)  # durations that are reported

_REMEDIES = {
    errno.EADDRINUSE: "another program uses it; close that program, or choose another port",
    errno.EADDRNOTAVAIL: "no interface of this computer has that address; `ip address` lists them",
    errno.ENODEV: "no interface of this computer can be used for it; `ip address` lists them",
    errno.ENOENT: "there is no such device; check its cable, and `ls /dev/tty*` for its name",
    errno.EACCES: "no permission; for a serial line: sudo usermod -aG dialout $USER",
    errno.ECONNREFUSED: "nothing listens there; check that the server runs, its host and port",
    errno.ENOTTY: "not a serial line; check the name of the device",
    errno.EBUSY: "another program uses it; close that program",
    **dict.fromkeys(
        (errno.ETIMEDOUT, errno.EHOSTUNREACH, errno.ENETUNREACH),
        "that computer does not answer; check that it is switched on and in the same network",
    ),
}
_SILENCE = {
    "mcast": "check that the boats have power, and that their radio's program sends to this group",
    "udpin": "check that the boats have power, and that their radio's program sends to this port",
    "tcp": "check that the boats have power, and that the server passes on what it hears",
}
_LINE_SILENCE = "check that the boats have power, and the radio's pairing and baud rate"


def of_error(error: Exception) -> str:
    """An operating system error as a sentence, without its number."""
    if isinstance(error, socket.gaierror):
        return "no computer has that name; check the spelling, or give the address"
    number = error.args[0] if error.args else 0
    text = error.args[1] if len(error.args) > 1 else error
    return _REMEDIES.get(number, str(text).lower())


def of_silence(address: str, silent_s: float) -> str | None:
    """The alarm for a source that is open but silent; None before 3 s."""
    told = [s for s in SILENT_S if s <= silent_s]
    if not told:
        return None
    remedy = _SILENCE.get(address.partition(":")[0], _LINE_SILENCE)
    return f"nothing heard for {told[-1]} s: {remedy}"
