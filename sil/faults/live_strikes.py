# SPDX-License-Identifier: MIT
"""Faults of a live flotillad, its bus and its disk: how to inject and end them."""

import errno
import os
import signal
import socket
import struct
import zlib
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from sil.faults.live_outing import INTERFACE, SYSTEM, LiveOuting

DISK_BYTES = 1 << 20
_NEW_LINK, _DEL_LINK, _REQUEST_ACK, _UP = 16, 17, 5, 1
_CAN_ERR_BUSOFF, _CAN_ERR_RESTARTED = 0x40, 0x100
_NEW_GAIN = {"LAW_KX": 0.21}
_UNSAVED = "could not be saved"


def _nothing(_: LiveOuting) -> str:
    return ""


def _words(outing: LiveOuting) -> str:
    """The content of flotillad's log file."""
    return (outing.folder / "flotillad.log").read_text()


def _bus_untold(outing: LiveOuting) -> str:
    # other lines may follow, about late ticks on a busy machine
    told = [line for line in _words(outing).splitlines() if INTERFACE in line]
    is_told = bool(told) and "is down or missing" in told[-1]  # ": no such interface" may follow
    return "" if is_told else "flotillad does not say that its bus is down"


def _left(outing: LiveOuting) -> bool:
    return outing.state != "FORMATION" or outing.rests()


@dataclass(frozen=True)
class Strike:
    """How a fault begins and ends, when it counts as detected, and errors during it.

    `well`: whether the boat has recovered, with the operator's help.
    """

    begin: Callable[[LiveOuting], None]
    end: Callable[[LiveOuting], None]
    noticed: Callable[[LiveOuting], bool] = _left
    wrong: Callable[[LiveOuting], str] = _nothing
    well: Callable[[LiveOuting], bool] = LiveOuting.drives


def _signal(number: signal.Signals) -> Callable[[LiveOuting], None]:
    def send(outing: LiveOuting) -> None:
        assert outing.boat.process is not None
        outing.boat.process.send_signal(number)

    return send


def _kill(outing: LiveOuting) -> None:
    assert outing.boat.process is not None
    outing.boat.process.kill()
    outing.boat.process.wait()


def _start(outing: LiveOuting) -> None:
    outing.start()
    outing.wait(lambda: outing.state != "silent", "a word of the boat")


def _error_frame(kind: int) -> None:
    """Send an error frame, as a CAN controller's driver does."""
    with closing(socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)) as can:
        can.bind((INTERFACE,))
        can.send(struct.pack("=IB3x8s", socket.CAN_ERR_FLAG | kind, 8, b""))


def _go_bus_off(outing: LiveOuting) -> None:
    outing.boat.escs_speak = False  # a controller in bus-off receives nothing
    _error_frame(_CAN_ERR_BUSOFF)


def _restart_controller(outing: LiveOuting) -> None:
    _error_frame(_CAN_ERR_RESTARTED)
    outing.boat.escs_speak = True


def _link(kind: int, flags: int = 0, change: int = 0) -> Callable[[LiveOuting], None]:
    """Change the interface by rtnetlink(7); the change is complete on return.

    Starting ip(8) instead would take time, during which the boat sails on.
    """

    def ask(_: LiveOuting) -> None:
        index = socket.if_nametoindex(INTERFACE)
        about = struct.pack("=BxHiII", socket.AF_UNSPEC, 0, index, flags, change)
        head = struct.pack("=IHHII", 16 + len(about), kind, _REQUEST_ACK, 1, 0)
        with closing(socket.socket(socket.AF_NETLINK, socket.SOCK_RAW, 0)) as kernel:
            kernel.send(head + about)
            (error,) = struct.unpack_from("=i", kernel.recv(4096), 16)
        if error != 0:
            raise OSError(-error, f"{INTERFACE}: {os.strerror(-error)}")

    return ask


def _plug_in(outing: LiveOuting) -> None:
    outing.execute("ip", "link", "add", INTERFACE, "type", "vcan")
    outing.execute("ip", "link", "set", INTERFACE, "up")
    outing.reopen()


def _ballast(outing: LiveOuting) -> Path:
    return outing.disk / "ballast"


def _parameters(outing: LiveOuting) -> Path:
    return outing.disk / "parameters.txt"


def _fill(outing: LiveOuting) -> None:
    """Fill the disk to the last byte, then set parameters, which the boat must save."""
    with _ballast(outing).open("wb", buffering=0) as ballast:
        try:
            while True:
                ballast.write(bytes(4096))
        except OSError as error:
            if error.errno != errno.ENOSPC:
                raise
    for name, value in _NEW_GAIN.items():
        outing.say(outing.operator.set_parameter(SYSTEM, name, value))


def _empty(outing: LiveOuting) -> None:
    """Free the disk, without a command to the boat: it retries by itself."""
    _ballast(outing).unlink()


def _half_written(outing: LiveOuting) -> str:
    """An incomplete file's name: saved parameters must be whole, logs end with a whole line."""
    for log in outing.disk.glob("log/*.log"):
        if not log.read_bytes().endswith(b"\n"):
            return f"{log.name} ends within a line"
    for file in outing.disk.glob("parameters.txt*"):
        body, _, checksum = file.read_text().rpartition("crc32 = ")
        if file.suffix != ".new" and int(checksum or "0", 16) != zlib.crc32(body.encode()):
            return f"{file.name} is not whole"
    return ""


def _full(outing: LiveOuting) -> str:
    if "No space left on device" not in _words(outing):
        return "flotillad does not say that its logs have ended"
    return _half_written(outing) if outing.drives() else "no thrust"


def _saved(outing: LiveOuting) -> bool:
    text = _parameters(outing).read_text() if _parameters(outing).exists() else ""
    wanted = [f"{name} = {value:g}\n" for name, value in _NEW_GAIN.items()]
    return not _half_written(outing) and all(line in text for line in wanted)


STRIKES = {
    "stopped": Strike(_signal(signal.SIGSTOP), _signal(signal.SIGCONT)),
    "bus_off": Strike(_go_bus_off, _restart_controller, wrong=_bus_untold),
    "interface_down": Strike(
        _link(_NEW_LINK, 0, _UP), _link(_NEW_LINK, _UP, _UP), wrong=_bus_untold
    ),
    "interface_removed": Strike(_link(_DEL_LINK), _plug_in, wrong=_bus_untold),
    "disk_full": Strike(_fill, _empty, lambda outing: _UNSAVED in outing.text, _full, _saved),
    "killed": Strike(_kill, _start),
}
